"use strict";
const data = JSON.parse(document.getElementById("data").textContent);
const of = id => document.getElementById(id);
function make(name, attributes = {}, ...inside) {
  const element = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) if (value !== undefined) element.setAttribute(key, value);
  element.append(...inside.filter(part => part !== undefined && part !== ""));
  return element;
}
const plural = (count, one, many = one + "s") => `${count} ${count === 1 ? one : many}`;
const kind = row => row.kept ? "kept" : row.class;
const KINDS = ["converted", "kept", "needless", "refused"];

const { options, sections } = data;
of("about").textContent = `${plural(options.all, "option")} in ${plural(sections.all, "section")} of ${plural(data.files.length, "file")}`;
of("verdict").textContent = !data.usable ? "does not start yet" : data.errors ? "starts without some parts" : "starts";
of("verdict").classList.add(data.usable && !data.errors ? "pass" : "fail");

const counts = { converted: options.converted - options.kept, kept: options.kept, needless: options.needless, refused: options.refused };
const TOLD = { converted: "converted", kept: "kept in printer.cfg", needless: "needless", refused: "refused" };
for (const name of KINDS) of("tiles").append(make("div", {}, make("b", {}, String(counts[name])), make("span", {}, TOLD[name])));
of("tiles").append(make("div", {}, make("b", {}, String(data.to_do.length)), make("span", {}, "to do")));
for (const name of KINDS) if (counts[name]) of("share").append(make("i", { class: name, style: `flex: ${counts[name]}`, title: `${counts[name]} ${TOLD[name]}` }));

for (const text of data.to_do) of("todo").append(make("li", {}, make("input", { type: "checkbox", "aria-label": "done" }), make("span", {}, text)));

of("wires").append(make("thead", {}, make("tr", {}, ...["what", "was on", "goes to", "pin", ""].map(text => make("th", {}, text)))));
const body = make("tbody");
for (const wire of data.wires) {
  body.append(make("tr", {}, make("td", {}, wire.what), make("td", {}, make("code", {}, wire.old)), make("td", {}, wire.label),
    make("td", {}, make("code", {}, wire.pin)), make("td", { class: "quiet" }, wire.remark)));
}
of("wires").append(body);

of("findings").textContent = data.findings.join("\n");
of("found").hidden = data.findings.length === 0;

const shown = new Set(KINDS);
for (const name of KINDS) {
  const box = make("input", { type: "checkbox" });
  box.checked = true;
  box.addEventListener("change", () => { box.checked ? shown.add(name) : shown.delete(name); filter(); });
  of("filters").append(make("label", { class: "check" }, box, make("span", { class: `badge ${name}` }, TOLD[name])));
}
of("search").addEventListener("input", filter);

const rows = [];
function after(row) {
  const parts = row.becomes.map(text => make("div", {}, make("code", { class: "now" }, text)));
  const why = [row.reason, row.nearest && row.nearest !== "nothing" ? `nearest: ${row.nearest}` : ""].filter(Boolean).join("; ");
  return [...parts, make("span", { class: "quiet" }, why)];
}
// Macros are many, and nothing has become of them: they stand behind what has changed.
const isKept = section => section.options.length > 0 && section.options.every(option => option.kept);
for (const section of [...data.account].sort((a, b) => isKept(a) - isKept(b))) {
  const count = {};
  for (const option of section.options) count[kind(option)] = (count[kind(option)] ?? 0) + 1;
  const badges = section.options.length
    ? KINDS.filter(name => count[name]).map(name => make("span", { class: `badge ${name}` }, `${count[name]} ${name}`))
    : [make("span", { class: `badge ${kind(section)}` }, kind(section))];
  const table = make("table", { class: "sides" },
    make("thead", {}, make("tr", {}, make("th", {}, "printer.cfg"), make("th", {}, ""), make("th", {}, "config.ini"))));
  const body = make("tbody");
  const own = [];
  for (const option of section.options) {
    const before = option.value.includes("\n") || option.value.length > 60
      ? make("pre", {}, `${option.option}: ${option.value}`) : make("code", {}, `${option.option}: ${option.value}`);
    const row = make("tr", {}, make("td", { title: option.at }, before, ...option.earlier.map(text => make("div", { class: "quiet" }, `replaces ${text}`))),
      make("td", {}, make("span", { class: `badge ${kind(option)}` }, kind(option))), make("td", {}, ...after(option)));
    own.push({ row, kind: kind(option), text: `${section.section} ${option.option} ${option.value} ${option.becomes.join(" ")}`.toLowerCase() });
    body.append(row);
  }
  table.append(body);
  const details = make("details", {}, make("summary", {}, make("code", {}, `[${section.section}]`),
    make("span", { class: "why" }, [section.reason, section.class === "refused" && section.nearest !== "nothing" ? `nearest: ${section.nearest}` : ""].filter(Boolean).join("; ")),
    ...badges, make("span", { class: "at" }, section.at)));
  if (section.options.length) details.append(table);
  of("sections").append(details);
  rows.push({ details, own, kind: kind(section), text: section.section.toLowerCase() });
}
function filter() {
  const wanted = of("search").value.toLowerCase();
  for (const section of rows) {
    let any = false;
    for (const { row, kind, text } of section.own) {
      row.hidden = !(shown.has(kind) && text.includes(wanted));
      any ||= !row.hidden;
    }
    section.details.hidden = section.own.length ? !any : !(shown.has(section.kind) && section.text.includes(wanted));
    if (wanted && any) section.details.open = true;
  }
}
for (const section of rows.filter(section => section.own.some(option => option.kind === "refused")).slice(0, 3)) section.details.open = true;

for (const line of data.config.split("\n")) {
  const mark = line.startsWith("[") ? "s" : line.startsWith("#") ? "c" : undefined;
  const cut = mark ? -1 : line.indexOf(" # ");
  of("config").append(make("span", { class: mark }, cut < 0 ? line : line.slice(0, cut)));
  if (cut >= 0) of("config").append(make("span", { class: "c" }, line.slice(cut)));
  of("config").append("\n");
}
