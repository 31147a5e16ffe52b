"use strict";
const data = JSON.parse(document.getElementById("data").textContent);
const of = id => document.getElementById(id);
const style = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const { wide, deep, low, size, surface } = data;
const range = data.highest[2] - data.lowest[2];
function mm(value, digits = 3) {
  const size = Math.abs(value).toFixed(digits);
  return (+size === 0 ? "" : value > 0 ? "+" : "\u2212") + size;
}

// The plane that the mesh tilts by; without it a bend is seen that a tilt hides.
const plane = (x, y) => data.mean + data.tilt[0] * ((x - low[0]) / size[0] - 0.5) + data.tilt[1] * ((y - low[1]) / size[1] - 0.5);
const placeX = column => low[0] + size[0] * column / (wide - 1), placeY = row => low[1] + size[1] * row / (deep - 1);
const levelled = () => of("level").checked;
const shown = () => surface.map((z, n) => levelled() ? z - plane(placeX(n % wide), placeY(Math.floor(n / wide))) : z);
const shownPoint = ([x, y, z]) => levelled() ? z - plane(x, y) : z;

// Blue is low, red is high, pale is between; as far on both sides, so that a flat bed looks flat.
const STOPS = [[44, 84, 168], [112, 164, 214], [240, 236, 228], [231, 148, 104], [176, 42, 48]];
function colour(share) {
  const at = Math.min(Math.max(share, 0), 1) * (STOPS.length - 1), index = Math.min(Math.floor(at), STOPS.length - 2), part = at - index;
  return STOPS[index].map((from, n) => Math.round(from + part * (STOPS[index + 1][n] - from)));
}
const css = (rgb, shade = 1) => `rgb(${rgb.map(c => Math.round(c * shade)).join(" ")})`;
function bounds(values) {
  const least = Math.min(...values), most = Math.max(...values), middle = (least + most) / 2;
  // A hundredth of a millimetre does not fill the scale.
  const half = Math.max((most - least) / 2, 0.02);
  return [middle - half, middle + half];
}

function begin(id) {
  const canvas = of(id), pen = canvas.getContext("2d"), ratio = window.devicePixelRatio || 1;
  const width = canvas.clientWidth, height = canvas.clientHeight;
  canvas.width = width * ratio; canvas.height = height * ratio;
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.fillStyle = style("--stage-high"); pen.fillRect(0, 0, width, height);
  pen.font = "12px system-ui, 'DejaVu Sans', sans-serif";
  return { pen, width, height };
}

// --- from above ---

function drawPlan() {
  const { pen, width, height } = begin("plan"), values = shown(), [least, most] = bounds(values);
  // Room for the heights at the outermost points.
  const left = 62, top = 26, right = 28, bottom = 34;
  const scale = Math.min((width - left - right) / size[0], (height - top - bottom) / size[1]);
  const x0 = left + (width - left - right - scale * size[0]) / 2, y0 = top + (height - top - bottom + scale * size[1]) / 2;
  const px = x => x0 + scale * (x - low[0]), py = y => y0 - scale * (y - low[1]);
  const picture = document.createElement("canvas");
  picture.width = wide; picture.height = deep;
  const image = new ImageData(wide, deep);
  values.forEach((z, n) => {
    const at = 4 * ((deep - 1 - Math.floor(n / wide)) * wide + n % wide);
    image.data.set([...colour((z - least) / (most - least)), 255], at);
  });
  picture.getContext("2d").putImageData(image, 0, 0);
  // The middles of the outermost pixels lie on the edge of the mesh.
  const half = [scale * size[0] / (wide - 1) / 2, scale * size[1] / (deep - 1) / 2];
  pen.save();
  pen.beginPath(); pen.rect(px(low[0]), py(low[1] + size[1]), scale * size[0], scale * size[1]); pen.clip();
  pen.imageSmoothingQuality = "high";
  pen.drawImage(picture, px(low[0]) - half[0], py(low[1] + size[1]) - half[1], scale * size[0] + 2 * half[0], scale * size[1] + 2 * half[1]);
  if (of("lines").checked) contours(pen, values, least, most, px, py);
  pen.restore();
  pen.strokeStyle = style("--grid"); pen.lineWidth = 1; pen.strokeRect(px(low[0]), py(low[1] + size[1]), scale * size[0], scale * size[1]);
  pen.fillStyle = style("--quiet"); pen.textBaseline = "top"; pen.textAlign = "center";
  for (const [x, align] of [[low[0], "left"], [low[0] + size[0] / 2, "center"], [low[0] + size[0], "right"]]) {
    pen.textAlign = align; pen.fillText((align === "center" ? "X " : "") + x.toFixed(0), px(x), py(low[1]) + 8);
  }
  pen.textAlign = "right"; pen.textBaseline = "middle";
  for (const [y, name] of [[low[1], ""], [low[1] + size[1] / 2, "Y "], [low[1] + size[1], ""]]) pen.fillText(name + y.toFixed(0), px(low[0]) - 24, py(y));
  marks(pen, px, py, scale);
  const stops = [0, 0.25, 0.5, 0.75, 1].map(share => css(colour(share)));
  of("key").style.background = `linear-gradient(90deg, ${stops.join(", ")})`;
  of("keylow").textContent = mm(least, 2); of("keyhigh").textContent = `${mm(most, 2)} mm`;
}

// A round interval that gives at most ten lines.
function interval(span) {
  const rough = span / 10, power = 10 ** Math.floor(Math.log10(rough));
  return power * [1, 2, 5, 10].find(times => times * power >= rough);
}
function contours(pen, values, least, most, px, py) {
  const step = interval(most - least);
  of("step").textContent = `every ${+step.toPrecision(1)} mm`;
  pen.lineWidth = 1; pen.strokeStyle = "rgb(40 24 48 / 34%)";
  for (let level = Math.ceil(least / step) * step; level <= most; level += step) {
    pen.beginPath();
    for (let row = 0; row + 1 < deep; row++) for (let column = 0; column + 1 < wide; column++) {
      const n = row * wide + column;
      const corners = [[column, row, values[n]], [column + 1, row, values[n + 1]], [column + 1, row + 1, values[n + wide + 1]], [column, row + 1, values[n + wide]]];
      const cuts = [];
      corners.forEach((a, side) => {
        const b = corners[(side + 1) % 4];
        if ((a[2] < level) === (b[2] < level)) return;
        const part = (level - a[2]) / (b[2] - a[2]);
        cuts.push([px(placeX(a[0] + part * (b[0] - a[0]))), py(placeY(a[1] + part * (b[1] - a[1])))]);
      });
      for (let pair = 0; pair + 1 < cuts.length; pair += 2) { pen.moveTo(...cuts[pair]); pen.lineTo(...cuts[pair + 1]); }
    }
    pen.stroke();
  }
}
function marks(pen, px, py, scale) {
  const room = Math.min(scale * size[0] / Math.max(data.count[0] - 1, 1), 2.4 * scale * size[1] / Math.max(data.count[1] - 1, 1));
  const written = of("values").checked && room > 36;
  pen.textAlign = "center"; pen.textBaseline = "alphabetic"; pen.lineJoin = "round"; pen.font = "11px system-ui, 'DejaVu Sans', sans-serif";
  for (const point of data.points) {
    const [x, y] = [px(point[0]), py(point[1])];
    pen.beginPath(); pen.fillStyle = "rgb(31 24 38 / 70%)"; pen.arc(x, y, 2.2, 0, 7); pen.fill();
    if (!written) continue;
    const text = mm(shownPoint(point), 2);
    pen.lineWidth = 3; pen.strokeStyle = "rgb(255 255 255 / 72%)"; pen.strokeText(text, x, y - 6);
    pen.fillStyle = "#1f1826"; pen.fillText(text, x, y - 6);
  }
}

// --- in space ---

let turn = -0.62, nod = 0.52;
function drawSpace() {
  const { pen, width, height } = begin("space"), values = shown(), [least, most] = bounds(values);
  const middle = (least + most) / 2, longest = Math.max(...size);
  // From true to a third of the bed's width.
  const fullest = 0.34 * longest / (most - least), times = Math.max(1, fullest ** (+of("times").value / 100));
  of("timesat").textContent = `${times.toFixed(0)}`;
  const scale = 0.72 * Math.min(width, 1.35 * height) / longest;
  const [c, s, cn, sn] = [Math.cos(turn), Math.sin(turn), Math.cos(nod), Math.sin(nod)];
  const project = (x, y, z) => {
    const [u, v, w] = [x - low[0] - size[0] / 2, y - low[1] - size[1] / 2, times * (z - middle)];
    const [a, b] = [c * u - s * v, s * u + c * v];
    return [width / 2 + scale * a, height / 2 - scale * (sn * b + cn * w), cn * b - sn * w];
  };
  const corner = n => project(placeX(n % wide), placeY(Math.floor(n / wide)), values[n]);
  const places = values.map((_, n) => corner(n));
  const floor = least - 0.12 * (most - least);
  pen.beginPath();
  [[0, 0], [1, 0], [1, 1], [0, 1]].forEach(([i, j], n) => {
    const [x, y] = project(low[0] + i * size[0], low[1] + j * size[1], floor);
    if (n) pen.lineTo(x, y); else pen.moveTo(x, y);
  });
  pen.closePath(); pen.fillStyle = style("--stage-low"); pen.fill(); pen.strokeStyle = style("--grid"); pen.stroke();
  const tiles = [];
  for (let row = 0; row + 1 < deep; row++) for (let column = 0; column + 1 < wide; column++) {
    const n = row * wide + column, four = [n, n + 1, n + wide + 1, n + wide];
    tiles.push({ four, depth: four.reduce((sum, at) => sum + places[at][2], 0) });
  }
  tiles.sort((a, b) => b.depth - a.depth);
  const [stepX, stepY] = [size[0] / (wide - 1), size[1] / (deep - 1)];
  for (const { four } of tiles) {
    const [a, b, d, e] = four.map(n => values[n]);
    const slopeX = times * (b + d - a - e) / 2 / stepX, slopeY = times * (e + d - a - b) / 2 / stepY;
    // Light from the front left and above.
    const light = (0.42 * slopeX + 0.42 * slopeY + 1) / Math.hypot(slopeX, slopeY, 1) / 1.16;
    pen.beginPath();
    four.forEach((n, index) => index ? pen.lineTo(places[n][0], places[n][1]) : pen.moveTo(places[n][0], places[n][1]));
    pen.closePath();
    pen.fillStyle = css(colour(((a + b + d + e) / 4 - least) / (most - least)), 0.72 + 0.32 * Math.max(light, 0));
    pen.strokeStyle = pen.fillStyle; pen.lineWidth = 0.7; pen.fill(); pen.stroke();
  }
  pen.fillStyle = style("--quiet"); pen.textAlign = "center"; pen.textBaseline = "middle";
  const names = [["front", 0.5, -0.1], ["rear", 0.5, 1.2], ["left", -0.1, 0.5], ["right", 1.1, 0.5]];
  for (const [name, i, j] of names) pen.fillText(name, ...project(low[0] + i * size[0], low[1] + j * size[1], floor).slice(0, 2));
}
const space = of("space");
space.addEventListener("pointerdown", event => space.setPointerCapture(event.pointerId));
space.addEventListener("pointermove", event => {
  if (!(event.buttons & 1)) return;
  turn += event.movementX * 0.008; nod = Math.min(Math.max(nod + event.movementY * 0.006, 0.08), 1.5);
  drawSpace();
});

// --- words and numbers ---

function tile(value, unit, name) {
  const box = document.createElement("div"), bold = document.createElement("b"), small = document.createElement("small"), text = document.createElement("span");
  bold.textContent = value + " "; small.textContent = unit; bold.append(small); text.textContent = name; box.append(bold, text); of("tiles").append(box);
}
tile(range.toFixed(3), "mm", "from lowest to highest");
tile((Math.abs(data.tilt[0]) + Math.abs(data.tilt[1])).toFixed(3), "mm", "tilt, corner to corner");
tile(mm(data.bend[0] + data.bend[1]), "mm", "bend: middle over corners");
tile(Math.abs(data.twist).toFixed(3), "mm", "twist");
tile(data.rest.toFixed(3), "mm", "what is left, standard deviation");
of("about").textContent = `${data.count[0]} \u00d7 ${data.count[1]} points, X ${low[0].toFixed(1)} to ${(low[0] + size[0]).toFixed(1)}, Y ${low[1].toFixed(1)} to ${(low[1] + size[1]).toFixed(1)} mm; ${data.interpolation} between them`;
of("verdict").textContent = range < 0.1 ? "flat" : `${range.toFixed(2)} mm uneven`;
of("verdict").classList.add(range < 0.3 ? "pass" : "fail");
for (const words of data.words) {
  const item = document.createElement("li");
  item.textContent = words; if (words.startsWith("To do")) item.className = "todo";
  of("words").append(item);
}
function table() {
  const rows = new Map();
  for (const point of data.points) rows.set(point[1], [...(rows.get(point[1]) || []), point].sort((a, b) => a[0] - b[0]));
  const [least, most] = bounds(shown()), sorted = [...rows.keys()].sort((a, b) => b - a), body = of("heights");
  body.textContent = "";
  const head = body.insertRow();
  head.append(document.createElement("th"), ...rows.get(sorted[0]).map(([x]) => Object.assign(document.createElement("th"), { textContent: `X ${+x.toFixed(1)}` })));
  for (const y of sorted) {
    const row = body.insertRow();
    row.append(Object.assign(document.createElement("th"), { textContent: `Y ${+y.toFixed(1)}` }));
    for (const point of rows.get(y)) {
      const cell = row.insertCell(), z = shownPoint(point), share = (z - least) / (most - least);
      cell.textContent = mm(z); cell.style.background = css(colour(share)); cell.style.color = share < 0.2 || share > 0.78 ? "#fff" : "#1f1826";
    }
  }
}
function draw() { drawPlan(); drawSpace(); }
for (const id of ["values", "lines"]) of(id).addEventListener("input", drawPlan);
of("times").addEventListener("input", drawSpace);
of("level").addEventListener("input", () => { draw(); table(); });
window.addEventListener("resize", draw);
table(); draw();
