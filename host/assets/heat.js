"use strict";
{
  const dark = matchMedia("(prefers-color-scheme: dark)").matches;
  if (dark) document.documentElement.dataset.theme = "dark";
  const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const element = (id) => document.getElementById(id);
  const text = (tag, words) => { const node = document.createElement(tag); node.textContent = words; return node; };

  const code = data.is_model ? "M306" : "M303", name = data.heater || "heater";
  document.title = `${name} - Velvet heater`;
  element("title").textContent = `${name}, tuned at ${data.target} °C`;
  element("about").textContent = `${code}, ${Math.round(data.time.at(-1))} s, ${data.swings.length} ${data.swings.length === 1 ? "swing" : "swings"} around the target`
    + (data.failed ? "; it found nothing" : "");

  const axes = (unit, size) => [
    { stroke: css("--quiet"), grid: { stroke: css("--line"), width: 1 }, ticks: { show: false }, size: 30, values: (_, ticks) => ticks.map((t) => `${+t.toFixed(1)} s`) },
    { stroke: css("--quiet"), grid: { stroke: css("--line"), width: 1 }, ticks: { show: false }, size, values: (_, ticks) => ticks.map((t) => `${+t.toFixed(1)} ${unit}`) },
  ];
  const has_model = Array.isArray(data.model);
  const keys = [["--s1", "read"], ...(has_model ? [["--s2", "model"]] : []), ["--s3", "slopes that were measured"]];
  element("keys").innerHTML = keys.map(([colour, words]) => `<span class="key"><i style="background: var(${colour})"></i>${words}</span>`).join("")
    + '<span class="key"><i class="dashes"></i>target</span>';

  // What was measured of each swing, drawn over the curves.
  const marks = (names) => (self) => {
    const pen = self.ctx, ratio = devicePixelRatio;
    const at = ([x, y]) => [self.valToPos(x, "x", true), self.valToPos(y, "y", true)];
    const line = (from, to, colour, width, dash = []) => {
      pen.strokeStyle = colour; pen.lineWidth = width * ratio; pen.setLineDash(dash.map((d) => d * ratio));
      pen.beginPath(); pen.moveTo(...at(from)); pen.lineTo(...at(to)); pen.stroke(); pen.setLineDash([]);
    };
    const { left, top, width, height } = self.bbox;
    pen.save(); pen.beginPath(); pen.rect(left, top, width, height); pen.clip();
    line([self.scales.x.min, data.target], [self.scales.x.max, data.target], css("--ink"), 1, [5, 4]);
    for (const swing of names ? data.swings.slice(0, 1) : data.swings) {
      const colour = css("--s3");
      line(swing.rise.from, [swing.meet, swing.celsius], colour, 2.5);
      line([swing.meet, swing.celsius], swing.fall.from, colour, 2.5);
      line(swing.fall.from, swing.fall.to, colour, 2.5);
      if (!names) continue;
      const low = self.scales.y.min + 0.16 * (self.scales.y.max - self.scales.y.min);
      line([swing.off, low - 0.4], [swing.off, swing.rise.to[1]], css("--quiet"), 1, [3, 3]);
      line([swing.meet, low - 0.4], [swing.meet, swing.celsius], css("--quiet"), 1, [3, 3]);
      line([swing.off, low], [swing.meet, low], css("--ink"), 3);
      pen.fillStyle = css("--ink"); pen.font = `${13 * ratio}px system-ui`; pen.textBaseline = "middle";
      const write = (words, place, dx, dy, align) => { pen.textAlign = align; 
        let [x, y] = at(place);
        x += dx * ratio; y += dy * ratio;
        const wide = pen.measureText(words).width, edge = align === "right" ? x - wide : x;
        pen.fillStyle = css("--card"); pen.fillRect(edge - 3 * ratio, y - 9 * ratio, wide + 6 * ratio, 18 * ratio);
        pen.fillStyle = css("--ink"); pen.fillText(words, x, y);
      };
      write(`late: ${(swing.meet - swing.off).toFixed(1)} s`, [swing.meet, low], 10, 0, "left");
      const middle = (from, to) => [(from[0] + to[0]) / 2, (from[1] + to[1]) / 2];
      write(`+${swing.rise.slope.toFixed(2)} °C/s`, middle(swing.rise.from, swing.rise.to), -12, -14, "right");
      write(`${swing.fall.slope.toFixed(2)} °C/s`, middle(swing.fall.from, swing.fall.to), 12, -14, "left");
      write("off", [swing.off, low], -8, 0, "right");
    }
    pen.restore();
  };

  const chart = (box, height, series, columns, unit, hooks, range, xrange) => {
    const plot = new uPlot({
      width: box.clientWidth, height, cursor: { sync: { key: "heat" }, drag: { x: true, y: false } }, legend: { show: false },
      scales: { x: { time: false, ...(xrange ? { range: xrange } : {}) }, y: { range } }, axes: axes(unit, 74),
      series: [{}, ...series], hooks,
    }, [data.time, ...columns], box);
    new ResizeObserver(() => plot.setSize({ width: box.clientWidth, height })).observe(box);
    return plot;
  };
  const curve = (colour, extra = {}) => ({ stroke: css(colour), width: 2, points: { show: false }, ...extra });
  const temperatures = [curve("--s1"), ...(has_model ? [curve("--s2", { width: 1.5 })] : [])];
  const columns = [data.celsius, ...(has_model ? [data.model] : [])];
  const around = (_, least, most) => { const room = 0.06 * Math.max(most - least, 5); return [least - room, most + room]; };
  const plots = [];
  let following = false;
  const follow = { setScale: [(self, key) => {
    if (key !== "x" || following) return;
    following = true;
    plots.filter((other) => other !== self).forEach((other) => other.setScale("x", { min: self.scales.x.min, max: self.scales.x.max }));
    following = false;
  }] };
  plots.push(chart(element("temperature"), 380, temperatures, columns, "°C", { draw: [marks(false)], ...follow }, around));
  plots.push(chart(element("output"), 130, [curve("--s4", { fill: `${css("--s4")}33`, paths: uPlot.paths.stepped({ align: -1 }) })], [data.output], "%", follow, () => [0, 105]));

  // The first swing whole, near by.
  const swing = data.swings[0];
  if (swing) {
    element("close").hidden = false;
    const span = [swing.rise.from[0] - 3, swing.fall.to[0] + 4];
    const inside = data.time.map((t) => t >= span[0] && t <= span[1]);
    const seen = columns.flatMap((column) => column.filter((_, index) => inside[index])).concat(swing.celsius);
    const room = 0.12 * (Math.max(...seen) - Math.min(...seen));
    element("close-facts").textContent = "both lines meet as long after it was switched off as its sensor is late";
    chart(element("swing"), 320, temperatures.map((one) => ({ ...one, points: { show: one === temperatures[0], size: 5 } })), columns, "°C",
      { draw: [marks(true)] }, () => [Math.min(...seen) - 2 * room, Math.max(...seen) + room], () => span);
  }

  data.facts.forEach((fact) => element("facts").append(text("li", fact)));
  if (data.gains.length) {
    element("found").hidden = false;
    element("found-title").textContent = data.is_model ? "The model" : "The gains";
    for (const [key, value, unit, means] of data.gains) {
      const row = document.createElement("tr"), figure = text("td", `${value}${unit ? ` ${unit}` : ""}`);
      figure.className = "n";
      row.append(text("td", key), figure, text("td", means));
      element("gains").append(row);
    }
  }
}
