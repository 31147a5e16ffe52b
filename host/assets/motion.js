"use strict";
{
  const dark = matchMedia("(prefers-color-scheme: dark)").matches;
  if (dark) document.documentElement.dataset.theme = "dark";
  const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const element = (id) => document.getElementById(id);
  const number = (value, digits = 0) => value.toLocaleString("en", { minimumFractionDigits: digits, maximumFractionDigits: digits });
  const largest = (values) => values.reduce((most, value) => Math.max(most, value), 0);

  document.title = `${data.title} - Velvet motion`;
  element("title").textContent = data.title;
  element("facts").textContent = data.time.length
    ? `${number(data.time.at(-1) - data.time[0], 1)} s shown, a sample every ${number(data.period_ms, 2)} ms; `
      + `at most ${number(largest(data.speed), 1)} mm/s, ${number(largest(data.acceleration))} mm/s²`
    : "Nothing moves in this time.";

  const axes = (unit) => [
    { stroke: css("--quiet"), grid: { stroke: css("--line"), width: 1 }, ticks: { show: false }, values: (_, ticks) => ticks.map((t) => `${+t.toFixed(3)} s`) },
    { stroke: css("--quiet"), grid: { stroke: css("--line"), width: 1 }, ticks: { show: false }, size: 84, values: (_, ticks) => ticks.map((t) => number(t)), label: unit, labelSize: 18 },
  ];
  const sync = uPlot.sync("motion");
  const chart = (title, unit, values, colour) => {
    const box = document.createElement("div");
    box.className = "chart";
    box.innerHTML = `<h3>${title}</h3>`;
    element("curves").append(box);
    const plot = new uPlot({
      width: box.clientWidth, height: 210, cursor: { sync: { key: sync.key }, drag: { x: true, y: false } },
      scales: { x: { time: false }, y: { range: (_, least, most) => [0, (most || 1) * 1.08] } }, axes: axes(unit),
      series: [
        { label: "time", value: (_, v) => (v === null ? "" : `${v.toFixed(4)} s`) },
        { label: title.toLowerCase(), stroke: css(colour), width: 1.3, fill: `${css(colour)}22`, points: { show: false }, value: (_, v) => (v === null ? "" : `${number(v)} ${unit}`) },
      ],
      hooks: { setScale: [(self, key) => { if (key === "x") plots.forEach((other) => follow(self, other)); }] },
    }, [data.time, values], box);
    new ResizeObserver(() => plot.setSize({ width: box.clientWidth, height: 210 })).observe(box);
    return plot;
  };
  const plots = [];
  let following = false;
  const follow = (from, to) => {
    if (following || from === to) return;
    following = true;
    to.setScale("x", { min: from.scales.x.min, max: from.scales.x.max });
    following = false;
  };
  plots.push(chart("Speed", "mm/s", data.speed, "--s1"));
  plots.push(chart("Acceleration", "mm/s²", data.acceleration, "--s2"));
  plots.push(chart("Jerk", "mm/s³", data.jerk, "--s3"));

  // A corner: both paths at one scale, the planned corner in the middle, as far as the paths part and some more.
  const reach = (corner) => {
    const near = (path) => path.map(([x, y]) => Math.hypot(x - corner.at[0], y - corner.at[1]));
    const closest = Math.min(...near(corner.shaped));
    return Math.max(0.05, closest * 6, 0.25 * Math.min(Math.max(...near(corner.planned)), 4));
  };
  const drawCorner = (canvas, corner) => {
    const size = canvas.clientWidth * devicePixelRatio;
    canvas.width = canvas.height = size;
    const pen = canvas.getContext("2d"), span = reach(corner), scale = size / (2 * span);
    const at = ([x, y]) => [size / 2 + (x - corner.at[0]) * scale, size / 2 - (y - corner.at[1]) * scale];
    const grid = 10 ** Math.floor(Math.log10(span));
    pen.strokeStyle = css("--line"); pen.lineWidth = devicePixelRatio;
    for (let step = -Math.ceil(span / grid); step <= span / grid; step++) {
      const place = size / 2 + step * grid * scale;
      pen.beginPath(); pen.moveTo(place, 0); pen.lineTo(place, size); pen.moveTo(0, place); pen.lineTo(size, place); pen.stroke();
    }
    for (const [path, colour] of [[corner.planned, "--s2"], [corner.shaped, "--s1"]]) {
      pen.strokeStyle = css(colour); pen.lineWidth = 2 * devicePixelRatio; pen.lineJoin = "round"; pen.beginPath();
      path.forEach((point, index) => { const [x, y] = at(point); if (index) pen.lineTo(x, y); else pen.moveTo(x, y); });
      pen.stroke();
    }
    pen.fillStyle = css("--quiet"); pen.font = `${12 * devicePixelRatio}px system-ui`;
    pen.fillText(`grid ${grid} mm`, 10 * devicePixelRatio, size - 10 * devicePixelRatio);
  };
  for (const corner of data.corners) {
    const figure = document.createElement("figure"), canvas = document.createElement("canvas"), caption = document.createElement("figcaption");
    caption.textContent = `X${number(corner.at[0], 2)} Y${number(corner.at[1], 2)}, passed at ${number(corner.speed, 1)} mm/s, ${number(corner.time, 2)} s from boot. Shaped by ${corner.shaper}.`;
    figure.append(canvas, caption);
    element("corners").append(figure);
    drawCorner(canvas, corner);
    new ResizeObserver(() => drawCorner(canvas, corner)).observe(canvas);
  }
  if (!data.corners.length) element("corners").textContent = "This job has no corner in the XY plane.";

  if (data.errors) {
    const { names, counts, max, rms } = data.errors, all = counts.reduce((sum, count) => sum + count, 0);
    element("error-facts").textContent = `${number(all)} step edges; at most ${number(max, 1)} ns off, rms ${number(rms, 2)} ns`;
    const last = counts.findLastIndex((count) => count > 0), most = Math.max(...counts);
    const rows = names.slice(0, last + 1).map((name, index) =>
      `<tr><td>${name}</td><td class="n">${number(counts[index])}</td><td class="n">${number(100 * counts[index] / all, counts[index] && counts[index] / all < 0.001 ? 4 : 1)} %</td>`
      + `<td class="bar">${counts[index] ? `<i style="width: ${100 * counts[index] / most}%"></i>` : ""}</td></tr>`);
    element("errors").innerHTML = `<table><thead><tr><th>Distance from ideal</th><th class="n">Edges</th><th class="n">Share</th><th class="bar"></th></tr></thead><tbody>${rows.join("")}</tbody></table>`;
  } else {
    element("errors").textContent = `Not compared: ${data.missing}.`;
  }
}
