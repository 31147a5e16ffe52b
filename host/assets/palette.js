"use strict";
// Colours of things that have names: objects, features. The same order on every page.
const PLAIN = ["#8e2468", "#1f7a8c", "#c2651a", "#5b52b5", "#3f7d3a", "#b8901f", "#d06ba6", "#4a6fa5", "#7a4a2a", "#2a9d7c", "#a04040", "#78808a"];
