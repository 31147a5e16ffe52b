"use strict";
const data = JSON.parse(document.getElementById("data").textContent);
const of = id => document.getElementById(id);
const bytes = Uint8Array.from(atob(data.places), c => c.charCodeAt(0));
const places = new Float32Array(bytes.buffer);
const count = places.length / 7;
const style = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

// The ranges of speed and flow are those of moves that feed filament, where there are any.
const prints = [...Array(count).keys()].some(n => places[7 * n + 4] > 0);
// A few moves beyond the rest would leave one colour for all others: the range is that of 96 in a hundred.
const range = column => {
  const step = Math.max(Math.floor(count / 50000), 1), values = [];
  for (let n = 0; n < count; n += step) if (!prints || places[7 * n + 4] > 0) values.push(places[7 * n + column]);
  values.sort((a, b) => a - b);
  const at = share => values[Math.round(share * (values.length - 1))];
  return values.length ? [at(0.02), at(0.98)] : [0, 1];
};
const ranges = { 3: range(3), 4: range(4), 5: [0, Math.max(data.layers.length - 1, 1)] };
const heat = share => `hsl(${250 - 230 * share} 72% 50%)`;
const colour = (n, column) => {
  const value = places[7 * n + column];
  if (column === 6) return value ? PLAIN[(value - 1) % PLAIN.length] : "#999";
  const [low, high] = ranges[column];
  return heat(Math.min(Math.max((value - low) / Math.max(high - low, 1e-9), 0), 1));
};

// Where what is printed lies, with some room around it; of a job without filament, where it goes.
let box = [Infinity, Infinity, -Infinity, -Infinity];
for (let n = 1; n < count; n++) {
  if (prints && places[7 * n + 4] <= 0) continue;
  for (const m of [n - 1, n]) {
    const [x, y] = [places[7 * m], places[7 * m + 1]];
    box = [Math.min(box[0], x), Math.min(box[1], y), Math.max(box[2], x), Math.max(box[3], y)];
  }
}
if (!(box[0] <= box[2])) box = [0, 0, 100, 100];

// The first and the last place of each layer.
const spans = data.layers.map(() => [Infinity, -1]);
for (let n = 1; n < count; n++) {
  const span = spans[places[7 * n + 5]];
  if (span) { span[0] = Math.min(span[0], n); span[1] = n; }
}

const canvas = of("plan"), pen = canvas.getContext("2d");
function draw() {
  const ratio = window.devicePixelRatio || 1, width = canvas.clientWidth, height = canvas.clientHeight;
  canvas.width = width * ratio; canvas.height = height * ratio;
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.fillStyle = style("--stage-high"); pen.fillRect(0, 0, width, height);
  const margin = 30, scale = Math.min((width - 2 * margin) / Math.max(box[2] - box[0], 1), (height - 2 * margin) / Math.max(box[3] - box[1], 1));
  const px = x => (width - scale * (box[2] - box[0])) / 2 + scale * (x - box[0]);
  const py = y => (height + scale * (box[3] - box[1])) / 2 - scale * (y - box[1]);
  const layer = +of("layer").value, [first, last] = spans[layer] || [1, count - 1];
  const end = Math.round(first + (last - first) * +of("until").value / 1000), column = +of("paint").value;
  const line = (from, to, faint) => {
    let before = null;
    for (let n = from; n <= to; n++) {
      const works = !prints || places[7 * n + 4] > 0;
      if (!works && (faint || !of("travel").checked)) continue;
      const ink = faint ? style("--line") : works ? colour(n, column) : style("--travel");
      if (ink !== before) { if (before) pen.stroke(); pen.beginPath(); pen.strokeStyle = ink; pen.lineWidth = works ? 2 : 0.8; before = ink; }
      pen.moveTo(px(places[7 * n - 7]), py(places[7 * n - 6])); pen.lineTo(px(places[7 * n]), py(places[7 * n + 1]));
    }
    if (before) pen.stroke();
  };
  pen.lineCap = "round";
  if (of("below").checked && layer > 0) line(spans[0][0], first - 1, true);
  line(first, end, false);
  if (count > 0 && end < last) { pen.beginPath(); pen.fillStyle = style("--ink"); pen.arc(px(places[7 * end]), py(places[7 * end + 1]), 5, 0, 7); pen.fill(); }
  of("layerat").textContent = data.layers.length ? `${layer + 1} of ${data.layers.length}, Z ${data.layers[layer].toFixed(2)} mm` : "all";
  of("untilat").textContent = count ? `${places[7 * end + 3].toFixed(0)} mm/s, ${places[7 * end + 4].toFixed(1)} mm³/s` : "nothing moves";
  legend(column);
}
function legend(column) {
  const scale = of("scale"); scale.textContent = "";
  if (column === 6) {
    if (!data.objects.length) { scale.textContent = "the file names no objects"; return; }
    data.objects.forEach((name, n) => {
      const dot = document.createElement("span"); dot.className = "swatch"; dot.style.background = PLAIN[n % PLAIN.length];
      scale.append(dot, name);
    });
    return;
  }
  const [low, high] = ranges[column], unit = { 3: " mm/s", 4: " mm³/s", 5: "" }[column], add = column === 5 ? 1 : 0;
  const digits = column === 4 ? 1 : 0, bar = document.createElement("i");
  bar.style.background = `linear-gradient(90deg, ${[0, .25, .5, .75, 1].map(heat).join(",")})`;
  scale.append((low + add).toFixed(digits), bar, (high + add).toFixed(digits) + unit);
}

of("layer").max = Math.max(data.layers.length - 1, 0);
of("layer").value = Math.floor(data.layers.length / 2);
of("totals").textContent = data.totals + (data.cut ? "The path is too long to be drawn whole: its beginning is shown.\n" : "");
const stops = data.findings.filter(finding => finding.stops).length;
of("verdict").textContent = stops ? `${stops} stop the job` : "nothing stops it";
of("verdict").classList.add(stops ? "fail" : "pass");
const body = of("findings").tBodies[0];
for (const finding of data.findings) {
  const row = body.insertRow(); row.className = finding.stops ? "stops" : "";
  row.insertCell().textContent = `line ${finding.line}`;
  row.insertCell().textContent = finding.what;
  const fix = row.insertCell(); fix.textContent = finding.fix; fix.className = "quiet";
}
if (!data.findings.length) body.insertRow().insertCell().textContent = "Nothing.";
for (const id of ["layer", "until", "paint", "below", "travel"]) of(id).addEventListener("input", draw);
window.addEventListener("resize", draw);
draw();
