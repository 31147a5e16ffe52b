"use strict";
const data = JSON.parse(document.getElementById("data").textContent);
const of = id => document.getElementById(id);
const style = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const [columns, rows] = data.pixels, [width, height] = data.size, [left, below] = data.at;
const picture = new Image();

function add(parent, name, text = "", kind = "") {
  const element = document.createElement(name);
  element.textContent = text;
  if (kind) element.className = kind;
  parent.append(element);
  return element;
}

function begin(id) {
  const canvas = of(id), pen = canvas.getContext("2d"), ratio = window.devicePixelRatio || 1;
  const wide = canvas.clientWidth, high = canvas.clientHeight;
  canvas.width = wide * ratio; canvas.height = high * ratio;
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, wide, high);
  pen.font = "12px system-ui, 'DejaVu Sans', sans-serif";
  return { pen, wide, high };
}

// A step of 1, 2 or 5 times a power of ten that makes about so many parts of a length.
function step(length, parts) {
  const rough = length / parts, power = 10 ** Math.floor(Math.log10(rough));
  return power * ([1, 2, 5].find(times => times * power >= rough) ?? 10);
}
const mm = value => String(+value.toFixed(3));

// --- the picture ---

// Place of the picture's left upper corner, and points of the screen for a pixel of the laser.
const view = { x: 0, y: 0, scale: 1, isWhole: true };

function room() {
  return { wide: of("burnt").clientWidth, high: of("burnt").clientHeight };
}
const fitting = () => Math.min((room().wide - 48) / columns, (room().high - 48) / rows);

function centre(scale) {
  const { wide, high } = room();
  Object.assign(view, { scale, isWhole: true, x: (wide - columns * scale) / 2, y: (high - rows * scale) / 2 });
  drawBurnt();
}

function zoom(factor, x, y) {
  const scale = Math.min(Math.max(view.scale * factor, fitting() / 2), Math.max(60, fitting()));
  view.x = x - (x - view.x) * scale / view.scale;
  view.y = y - (y - view.y) * scale / view.scale;
  view.scale = scale;
  view.isWhole = false;
  drawBurnt();
}

function drawBurnt() {
  const { pen, wide, high } = begin("burnt"), { x, y, scale } = view;
  // Pixels a few points wide would be unequal: they are drawn soft, larger ones with their edges.
  pen.imageSmoothingEnabled = scale < 4;
  pen.imageSmoothingQuality = "high";
  pen.drawImage(picture, x, y, columns * scale, rows * scale);
  pen.strokeStyle = style("--grid");
  pen.strokeRect(x - 0.5, y - 0.5, columns * scale + 1, rows * scale + 1);
  // A ruler of about a fifth of the width.
  const bar = step(wide / scale * data.pixel, 12), length = bar / data.pixel * scale;
  pen.fillStyle = style("--card");
  pen.fillRect(12, high - 40, length + 24, 30);
  pen.fillStyle = style("--ink");
  pen.fillRect(24, high - 18, length, 2);
  pen.fillRect(24, high - 22, 1, 6);
  pen.fillRect(23 + length, high - 22, 1, 6);
  pen.fillText(`${mm(bar)} mm`, 24, high - 25);
}

function follow(canvas) {
  const fingers = new Map();
  const here = event => [event.offsetX, event.offsetY];
  const apart = () => { const [a, b] = [...fingers.values()]; return Math.hypot(a[0] - b[0], a[1] - b[1]); };
  canvas.addEventListener("pointerdown", event => { canvas.setPointerCapture(event.pointerId); fingers.set(event.pointerId, here(event)); });
  for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, event => fingers.delete(event.pointerId));
  canvas.addEventListener("pointermove", event => {
    say(here(event));
    const from = fingers.get(event.pointerId), to = here(event);
    if (!from) return;
    if (fingers.size === 1) {
      view.x += to[0] - from[0]; view.y += to[1] - from[1];
      view.isWhole = false;
      fingers.set(event.pointerId, to);
      drawBurnt();
    } else {
      const before = apart();
      fingers.set(event.pointerId, to);
      zoom(apart() / before, ...to);
    }
  });
  canvas.addEventListener("pointerleave", () => { of("under").textContent = ""; });
  canvas.addEventListener("wheel", event => { event.preventDefault(); zoom(Math.exp(-event.deltaY / 400), ...here(event)); }, { passive: false });
}

// Says the place of the machine under the pointer.
function say([x, y]) {
  const column = (x - view.x) / view.scale, row = (y - view.y) / view.scale;
  const inside = column >= 0 && row >= 0 && column < columns && row < rows;
  of("under").textContent = inside ? `X ${(left + column * data.pixel).toFixed(2)}  Y ${(below + (rows - row) * data.pixel).toFixed(2)}` : "";
}

// --- the machine ---

function drawMachine() {
  const places = [...data.leads, ...data.rapids].flat();
  const most = axis => places.reduce((end, place) => Math.max(end, place[axis]), data.at[axis] + data.size[axis]);
  const least = axis => places.reduce((end, place) => Math.min(end, place[axis]), data.at[axis]);
  const known = data.travel.flat().every(end => end !== null);
  const low = known ? data.travel[0] : [least(0), least(1)], high = known ? data.travel[1] : [most(0), most(1)];
  const margin = { left: 52, right: 16, top: 14, bottom: 30 };
  const span = [high[0] - low[0], high[1] - low[1]];
  const canvas = of("machine"), room = canvas.clientWidth - margin.left - margin.right;
  const scale = Math.min(room / span[0], 460 / span[1]);
  canvas.style.height = `${Math.max(span[1] * scale, 40) + margin.top + margin.bottom}px`;
  const { pen, high: tall } = begin("machine");
  const x0 = margin.left + (room - span[0] * scale) / 2;
  const px = x => x0 + (x - low[0]) * scale, py = y => tall - margin.bottom - (y - low[1]) * scale;
  if (known) {
    pen.fillStyle = style("--card");
    pen.fillRect(px(low[0]), py(high[1]), span[0] * scale, span[1] * scale);
  }
  axes(pen, low, high, px, py, scale, tall - margin.bottom);
  pen.lineWidth = Math.max(data.pixel * scale, 0.6);
  pen.imageSmoothingQuality = "high";
  pen.drawImage(picture, px(left), py(below + height), width * scale, height * scale);
  // Leads may lie within the picture: rows begin at their first burnt pixel.
  drawLeads(pen, canvas, px, py);
  pen.lineWidth = 1;
  pen.strokeStyle = style("--travel");
  pen.strokeRect(px(left), py(below + height), width * scale, height * scale);
  if (of("rapids").checked) {
    pen.strokeStyle = style("--accent");
    lines(pen, data.rapids, px, py);
  }
  if (known) {
    pen.strokeStyle = style("--ink");
    pen.strokeRect(px(low[0]), py(high[1]), span[0] * scale, span[1] * scale);
  }
  of("keytravel").parentElement.hidden = !known;
  of("ends").textContent = known ? "to scale, mm" : "to scale, mm; the travel is not known without --config";
}

// Rows lie closer than points of the screen, and their paint adds up: they are drawn apart, then laid over.
function drawLeads(pen, canvas, px, py) {
  const sheet = document.createElement("canvas"), ratio = window.devicePixelRatio || 1;
  sheet.width = canvas.width; sheet.height = canvas.height;
  const own = sheet.getContext("2d");
  own.setTransform(ratio, 0, 0, ratio, 0, 0);
  own.lineWidth = Math.max(pen.lineWidth, 1.2);
  own.strokeStyle = style("--s3");
  lines(own, data.leads, px, py);
  pen.globalAlpha = 0.4;
  pen.drawImage(sheet, 0, 0, sheet.width / ratio, sheet.height / ratio);
  pen.globalAlpha = 1;
}

function lines(pen, ways, px, py) {
  pen.beginPath();
  for (const [from, to] of ways) { pen.moveTo(px(from[0]), py(from[1])); pen.lineTo(px(to[0]), py(to[1])); }
  pen.stroke();
}

function axes(pen, low, high, px, py, scale, bottom) {
  const apart = step(100 / scale, 1);
  pen.lineWidth = 1;
  pen.strokeStyle = style("--line");
  pen.fillStyle = style("--quiet");
  pen.beginPath();
  pen.textAlign = "center";
  for (let x = Math.ceil(low[0] / apart) * apart; x <= high[0] + 1e-6; x += apart) {
    pen.moveTo(px(x), py(low[1])); pen.lineTo(px(x), py(high[1]));
    pen.fillText(mm(x), px(x), bottom + 18);
  }
  pen.textAlign = "right";
  for (let y = Math.ceil(low[1] / apart) * apart; y <= high[1] + 1e-6; y += apart) {
    pen.moveTo(px(low[0]), py(y)); pen.lineTo(px(high[0]), py(y));
    pen.fillText(mm(y), px(low[0]) - 8, py(y) + 4);
  }
  pen.textAlign = "left";
  pen.stroke();
}

// --- the page ---

function paint() {
  const system = matchMedia("(prefers-color-scheme: dark)");
  document.documentElement.dataset.theme = system.matches ? "dark" : "light";
  of("keytravel").style.background = style("--card");
  of("keylead").style.background = `color-mix(in srgb, ${style("--s3")} 40%, ${style("--card")})`;
  drawBurnt();
  drawMachine();
}

for (const [value, unit, name] of data.tiles) {
  const tile = add(of("tiles"), "div"), figure = add(tile, "b", value + (unit ? " " : ""));
  add(figure, "small", unit);
  add(tile, "span", name);
}
for (const [name, value] of data.rows) {
  const row = add(of("facts").tBodies[0], "tr");
  add(row, "td", name);
  add(row, "td", value);
}
picture.addEventListener("load", () => { centre(fitting()); paint(); });
picture.src = data.picture;
of("whole").addEventListener("click", () => centre(fitting()));
of("single").addEventListener("click", () => { const { wide, high } = room(); zoom(10 / view.scale, wide / 2, high / 2); });
of("rapids").addEventListener("change", drawMachine);
follow(of("burnt"));
window.addEventListener("resize", () => {
  if (view.isWhole) centre(fitting()); else drawBurnt();
  drawMachine();
});
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", paint);
