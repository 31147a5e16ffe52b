// Draws the page from the JSON in #data. No build step: uPlot and three.js stand before this script.
"use strict";
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const $ = (id) => document.getElementById(id);
  const element = (name, text, className) => {
    const node = document.createElement(name);
    if (text !== undefined) node.textContent = text;
    if (className) node.className = className;
    return node;
  };
  const count = (n) => Math.round(n).toLocaleString("en").replaceAll(",", "\u2009");
  const fixed = (n, digits) => (Math.abs(n) < 0.5 * 10 ** -digits ? 0 : n).toFixed(digits);
  const clock = (s) => {
    const minutes = Math.floor(s / 60);
    return minutes > 0 ? `${minutes} min ${fixed(s - 60 * minutes, 0).padStart(2, "0")} s` : `${fixed(s, 1)} s`;
  };
  const largest = (numbers) => numbers.reduce((a, b) => (b > a ? b : a), 0);
  const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const onTheme = [];

  // --- light and dark -------------------------------------------------------------------------------------------
  const stored = (() => { try { return localStorage.getItem("velvet-theme"); } catch { return null; } })();
  const system = matchMedia("(prefers-color-scheme: dark)");
  let chosen = stored;
  const setTheme = () => {
    document.documentElement.dataset.theme = chosen ?? (system.matches ? "dark" : "light");
    for (const redraw of onTheme) redraw();
  };
  system.addEventListener("change", setTheme);
  $("theme").addEventListener("click", () => {
    chosen = document.documentElement.dataset.theme === "dark" ? "light" : "dark";
    try { localStorage.setItem("velvet-theme", chosen); } catch { /* a page opened from a file may have no storage */ }
    setTheme();
  });
  setTheme();

  // --- words and tables -----------------------------------------------------------------------------------------
  const failed = data.checks.filter((check) => check.verdict === "fail").length;
  const passed = data.checks.filter((check) => check.verdict === "pass").length;
  $("verdict").textContent = failed ? `${failed} of ${failed + passed} checks failed` : `All ${passed} checks passed`;
  $("verdict").classList.add(failed ? "fail" : "pass");
  $("facts").textContent = data.halted ? `Halted: ${data.halted}` : `A job of ${count(data.lines)} lines, done in ${clock(data.seconds)} of machine time`;

  const marks = { pass: "\u2713", fail: "\u2717", skipped: "\u2013" };
  const named = { pass: "passed", fail: "failed", skipped: "not checked" };
  for (const check of data.checks) {
    const row = element("tr", undefined, check.verdict);
    const mark = element("span", marks[check.verdict], `mark ${check.verdict}`);
    mark.title = named[check.verdict];
    row.append(element("td"), element("td", check.what), element("td", check.found));
    row.firstChild.append(mark);
    $("checks").tBodies[0].append(row);
  }

  const topRate = largest(data.motors.map((motor) => motor.max_rate));
  for (const motor of data.motors.filter((motor) => motor.edges > 0)) {
    const row = element("tr");
    const bar = element("td", undefined, "bar");
    bar.append(element("i"));
    bar.firstChild.style.width = `${(100 * motor.max_rate) / (topRate || 1)}%`;
    row.append(element("td", motor.name), element("td", count(motor.edges), "n"),
      element("td", `${fixed(motor.position, 3)} mm`, "n"), element("td", `${count(motor.max_rate)} /s`, "n"), bar);
    $("motors").tBodies[0].append(row);
  }
  for (const heater of data.heaters) {
    const row = element("tr");
    row.append(element("td", heater.name), element("td", `${fixed(heater.max, 1)} \u00b0C`, "n"),
      element("td", `${fixed(heater.last, 1)} \u00b0C`, "n"));
    $("heaters").tBodies[0].append(row);
  }
  if (!data.heaters.length) { $("heaters").hidden = true; $("heatershead").hidden = true; }
  if (data.console) $("console").textContent = data.console; else $("consolecard").hidden = true;
  $("foot").append("Step edges hash to ", element("code", data.hash), ". The same job on the same machine gives the same hash.");

  const tile = (value, unit, label) => {
    const box = element("div");
    const number = element("b", value);
    number.append(element("small", unit ? ` ${unit}` : ""));
    box.append(number, element("span", label));
    $("tiles").append(box);
  };
  tile(clock(data.seconds), "", "machine time");
  tile(count(data.lines), "", "lines of G-code");
  tile(count(data.edges), "", "step edges");
  tile(count(topRate), "/s", "top step rate");
  tile(fixed(largest(data.speed.tool), 0), "mm/s", "top speed");
  if (data.power) tile(clock(data.power.on_seconds), "", "laser on");
  if (data.path.filament > 0) tile(fixed(data.path.filament / 1000, 2), "m", "filament laid");
  // The first second is the boot's: supplies rise, the processor sets itself up.
  const booted = (values) => values.filter((value, n) => value !== null && data.telemetry.time[n] >= 1);
  const load = booted(data.telemetry.cpu[0]?.values ?? []);
  if (load.length) tile(fixed(100 * largest(load), 0), "%", "highest CPU load");

  // --- the path -------------------------------------------------------------------------------------------------
  const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer;
  const path = {
    xyz: new Float32Array(bytes(data.path.xyz)),
    time: new Float32Array(bytes(data.path.time)),
    speed: new Float32Array(bytes(data.path.speed)),
    work: new Uint8Array(bytes(data.path.work)),
    power: data.path.power && new Float32Array(bytes(data.path.power)),
  };
  if (path.power) {
    $("paintpower").hidden = false;
    $("paintpower").firstChild.checked = true;
    $("travelname").textContent = "Dark moves";
  }
  const corners = path.work.length;
  const begin = corners ? path.time[0] : 0;
  const end = corners ? path.time[corners - 1] : data.seconds;
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  let fastest = 0;
  for (let i = 1; i < corners; i += 1) {
    if (!path.work[i]) continue;
    fastest = Math.max(fastest, path.speed[i]);
    for (let axis = 0; axis < 3; axis += 1) {
      low[axis] = Math.min(low[axis], path.xyz[3 * i + axis]);
      high[axis] = Math.max(high[axis], path.xyz[3 * i + axis]);
    }
  }
  if (fastest === 0) { low.fill(0); high.fill(10); }

  // Dark to light through one family of colours: readable on both papers, and by those who do not see red and green.
  const ramp = [[0.20, 0.11, 0.42], [0.48, 0.13, 0.56], [0.80, 0.24, 0.47], [0.95, 0.49, 0.28], [0.99, 0.82, 0.38]];
  const rampAt = (share) => {
    const at = Math.min(Math.max(share, 0), 1) * (ramp.length - 1);
    const i = Math.min(Math.floor(at), ramp.length - 2);
    return ramp[i].map((from, k) => from + (at - i) * (ramp[i + 1][k] - from));
  };
  document.querySelector(".legend i").style.background = `linear-gradient(90deg, ${ramp.map((c) => `rgb(${c.map((v) => Math.round(255 * v))})`)})`;
  const paint = () => document.querySelector("input[name=paint]:checked").value;
  // What each piece is made for, and the part of the job that is looked at: a layer, or all of it.
  let [first, final, isReady, marked] = [begin, end, false, null];
  const account = drawAccount({ account: data.account, prints: data.path.filament > 0, $, element, fixed, clock, css, onTheme }, {
    window(layer) {
      [first, final] = layer ? [Math.min(Math.max(begin, layer.from), end), Math.max(Math.min(end, layer.to), begin)] : [begin, end];
      marked = null;
      if (!isReady) return;
      setPlaying(false);
      stage.repaint();
      setTime(final);
    },
    look: () => $("stage").scrollIntoView({ behavior: "smooth", block: "start" }),
    mark(from, to) {
      marked = [from, to];
      stage.repaint();
      setTime(to);
    },
  });
  const made = Array.from({ length: corners }, (_, i) => (i ? account.labelAt((path.time[i - 1] + path.time[i]) / 2) : { feature: 0, object: 0 }));
  const rgbOf = (hex) => {
    const full = hex.length === 4 ? hex.replace(/[0-9a-f]/gi, "$&$&") : hex;
    return [1, 3, 5].map((at) => parseInt(full.slice(at, at + 2), 16) / 255);
  };
  $("paintfeature").hidden = !account.names.feature.length;
  $("paintobject").hidden = !account.names.object.length;
  const shade = (i) => {
    // Below the layer that is looked at.
    const at = (path.time[i - 1] + path.time[i]) / 2;
    if (marked && at >= marked[0] && at <= marked[1]) return rgbOf("#f2c500");
    if (first > begin && path.time[i] <= first) return rgbOf(css("--grid"));
    switch (paint()) {
      case "feature":
      case "object": return rgbOf(account.plain(made[i][paint()]));
      case "power": return rampAt(path.power[i]);
      case "speed": return rampAt((path.speed[i] + path.speed[i - 1]) / 2 / (fastest || 1));
      case "height": return rampAt((path.xyz[3 * i + 2] - low[2]) / (high[2] - low[2] || 1));
      default: return null;
    }
  };
  const setLegend = () => {
    const texts = { power: ["0", "100 %"], speed: ["0", `${fixed(fastest, 0)} mm/s`], height: [`${fixed(low[2], 1)}`, `${fixed(high[2], 1)} mm`] }[paint()];
    document.querySelector(".legend").hidden = !texts;
    document.querySelector(".legend").style.display = texts ? "" : "none";
    if (texts) [$("low").textContent, $("high").textContent] = texts;
    const list = account.names[paint()] ?? [];
    $("names").hidden = !list.length;
    $("names").replaceChildren(...list.map(({ name, colour }) => {
      const line = element("span");
      line.append(element("i", undefined, "swatch"), name);
      line.firstChild.style.background = colour;
      return line;
    }));
  };
  // First corner later than a time.
  const cornerAt = (seconds) => {
    let [a, b] = [0, corners];
    while (a < b) {
      const middle = (a + b) >> 1;
      if (path.time[middle] <= seconds) a = middle + 1; else b = middle;
    }
    return a;
  };
  const positionAt = (seconds) => {
    const after = Math.min(Math.max(cornerAt(seconds), 1), corners - 1);
    const span = path.time[after] - path.time[after - 1];
    const share = span > 0 ? Math.min(Math.max((seconds - path.time[after - 1]) / span, 0), 1) : 1;
    return [0, 1, 2].map((k) => path.xyz[3 * after - 3 + k] + share * (path.xyz[3 * after + k] - path.xyz[3 * after - 3 + k]));
  };

  const stage = corners > 1 ? solidStage() ?? flatStage() : { show() {}, repaint() {} };

  // The part as lit threads, by three.js; null where the browser has no WebGL.
  function solidStage() {
    let renderer;
    try { renderer = new THREE.WebGLRenderer({ antialias: true, alpha: true }); } catch { return null; }
    const view = $("view");
    view.append(renderer.domElement);
    renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    const scene = new THREE.Scene();
    const camera = new THREE.PerspectiveCamera(32, 1, 0.1, 10000);
    camera.up.set(0, 0, 1);
    const size = Math.max(...high.map((h, k) => h - low[k]), 1);
    const middle = new THREE.Vector3(...high.map((h, k) => (h + low[k]) / 2));
    // A laser's picture is flat, and is looked at from above.
    const side = path.power ? [0, -0.02, 2.1] : [-0.95, -1.75, 1.0];
    camera.position.copy(middle).add(new THREE.Vector3(...side).multiplyScalar(size * 1.25));
    const orbit = new THREE.OrbitControls(camera, renderer.domElement);
    orbit.target.copy(middle).add(new THREE.Vector3(0, 0, -0.12 * size));
    orbit.enableDamping = true;
    orbit.autoRotateSpeed = -1.6;
    orbit.minDistance = size * 0.05;
    orbit.maxDistance = size * 30;
    orbit.zoomSpeed = 0.6;

    scene.add(new THREE.HemisphereLight(0xffffff, 0x8a7a96, 1.9));
    const sun = new THREE.DirectionalLight(0xfff4e8, 2.1);
    sun.position.set(-1, -0.6, 1.4);
    const rim = new THREE.DirectionalLight(0xd9c8ff, 0.9);
    rim.position.set(1.2, 1, 0.3);
    scene.add(sun, rim);

    // The bed: a grid of 10 mm around the part.
    const pitch = size > 400 ? 100 : 10;
    const half = Math.ceil((size * 1.1) / pitch) * pitch;
    const cells = (2 * half) / pitch;
    const bed = new THREE.GridHelper(2 * half, cells);
    bed.rotation.x = Math.PI / 2;
    bed.position.set(Math.round(middle.x / pitch) * pitch, Math.round(middle.y / pitch) * pitch, Math.min(0, low[2]));
    bed.material.transparent = true;
    bed.material.opacity = 0.55;
    bed.material.vertexColors = false;
    scene.add(bed);

    // One cylinder for each worked piece, in order of time; drawing the first n shows the part at a time.
    const worked = [];
    const travelled = [];
    for (let i = 1; i < corners; i += 1) (path.work[i] ? worked : travelled).push(i);
    const tube = data.path.tube;
    const thread = new THREE.InstancedMesh(new THREE.CylinderGeometry(0.5, 0.5, 1, 10, 1, false),
      new THREE.MeshLambertMaterial({ color: 0xffffff }), worked.length);
    const from = new THREE.Vector3();
    const to = new THREE.Vector3();
    const up = new THREE.Vector3(0, 1, 0);
    const way = new THREE.Vector3();
    const turn = new THREE.Quaternion();
    const scale = new THREE.Vector3();
    const matrix = new THREE.Matrix4();
    worked.forEach((i, n) => {
      from.fromArray(path.xyz, 3 * i - 3);
      to.fromArray(path.xyz, 3 * i);
      way.subVectors(to, from);
      const length = way.length();
      turn.setFromUnitVectors(up, length > 0 ? way.divideScalar(length) : up);
      // A little longer than the piece, so that corners have no gaps.
      scale.set(tube, length + tube * 0.45, tube);
      matrix.compose(from.add(to).multiplyScalar(0.5), turn, scale);
      thread.setMatrixAt(n, matrix);
    });
    thread.frustumCulled = false;
    scene.add(thread);

    const moves = new THREE.BufferGeometry();
    const ends = new Float32Array(travelled.length * 6);
    travelled.forEach((i, n) => ends.set(path.xyz.subarray(3 * i - 3, 3 * i + 3), 6 * n));
    moves.setAttribute("position", new THREE.BufferAttribute(ends, 3));
    const travel = new THREE.LineSegments(moves, new THREE.LineBasicMaterial({ transparent: true, opacity: 0.6 }));
    travel.frustumCulled = false;
    travel.visible = false;
    scene.add(travel);

    const nozzleSize = Math.max(tube * 3, size * 0.05);
    const nozzle = new THREE.Mesh(new THREE.ConeGeometry(nozzleSize * 0.55, nozzleSize * 1.3, 24), new THREE.MeshLambertMaterial());
    nozzle.geometry.rotateX(-Math.PI / 2);
    nozzle.geometry.translate(0, 0, nozzleSize * 0.65);
    scene.add(nozzle);

    let dirty = true;
    const colour = new THREE.Color();
    const repaint = () => {
      const plain = colour.set(css("--part")).clone();
      worked.forEach((i, n) => {
        const rgb = shade(i);
        thread.setColorAt(n, rgb ? colour.setRGB(...rgb, "srgb") : plain);
      });
      thread.instanceColor.needsUpdate = true;
      travel.material.color.set(css("--travel"));
      bed.material.color.set(css("--grid"));
      nozzle.material.color.set(css("--accent"));
      dirty = true;
    };
    const below = (list, limit) => {
      let [a, b] = [0, list.length];
      while (a < b) { const m = (a + b) >> 1; if (list[m] < limit) a = m + 1; else b = m; }
      return a;
    };
    const show = (seconds) => {
      const limit = cornerAt(seconds);
      thread.count = below(worked, limit);
      moves.setDrawRange(0, 2 * below(travelled, limit));
      nozzle.position.fromArray(positionAt(seconds));
      nozzle.visible = seconds < end;
      dirty = true;
    };
    const fit = () => {
      const { clientWidth: width, clientHeight: height } = view;
      renderer.setSize(width, height, false);
      camera.aspect = width / height;
      // A narrow window sees as much of the part's width as a square one.
      camera.fov = camera.aspect < 1 ? (360 / Math.PI) * Math.atan(Math.tan((16 * Math.PI) / 180) / camera.aspect) : 32;
      camera.updateProjectionMatrix();
      dirty = true;
    };
    new ResizeObserver(fit).observe(view);
    fit();
    orbit.addEventListener("change", () => { dirty = true; });
    const frame = () => {
      requestAnimationFrame(frame);
      orbit.autoRotate = playing && !path.power && !matchMedia("(prefers-reduced-motion: reduce)").matches;
      orbit.update();
      if (!dirty) return;
      dirty = false;
      renderer.render(scene, camera);
    };
    requestAnimationFrame(frame);
    return { show, repaint, setTravel(on) { travel.visible = on; dirty = true; } };
  }

  // Without WebGL: the same lines, drawn flat from the same side.
  function flatStage() {
    const canvas = element("canvas");
    $("view").append(canvas);
    const pen = canvas.getContext("2d");
    let [until, withTravel] = [end, false];
    const draw = () => {
      const ratio = Math.min(devicePixelRatio, 2);
      canvas.width = canvas.clientWidth * ratio;
      canvas.height = canvas.clientHeight * ratio;
      const size = Math.max(...high.map((h, k) => h - low[k]), 1);
      const zoom = (0.62 * Math.min(canvas.width, canvas.height)) / size;
      const middle = high.map((h, k) => (h + low[k]) / 2);
      const project = (i) => {
        const [x, y, z] = [0, 1, 2].map((k) => path.xyz[3 * i + k] - middle[k]);
        return [canvas.width / 2 + zoom * (0.88 * x - 0.47 * y), canvas.height / 2 - zoom * (0.87 * z + 0.24 * x + 0.43 * y)];
      };
      pen.lineWidth = Math.max(ratio, data.path.tube * zoom * 0.5);
      const last = cornerAt(until);
      for (let i = 1; i < last; i += 1) {
        if (!path.work[i] && !withTravel) continue;
        const rgb = path.work[i] ? shade(i) : null;
        pen.strokeStyle = rgb ? `rgb(${rgb.map((v) => Math.round(255 * v))})` : css(path.work[i] ? "--part" : "--travel");
        pen.beginPath();
        pen.moveTo(...project(i - 1));
        pen.lineTo(...project(i));
        pen.stroke();
      }
    };
    new ResizeObserver(draw).observe($("view"));
    return {
      show(seconds) { until = seconds; draw(); },
      repaint: draw,
      setTravel(on) { withTravel = on; draw(); },
    };
  }

  // --- charts ---------------------------------------------------------------------------------------------------
  const charts = [];
  const chart = (title, time, series, axes, height = 200) => {
    const box = element("div", undefined, "chart");
    box.append(element("h3", title));
    $("charts").append(box);
    let plot;
    const build = () => {
      const cursor = plot?.cursor.left ?? -10;
      plot?.destroy();
      const axis = (more) => ({
        stroke: css("--quiet"), grid: { stroke: css("--line"), width: 1 }, ticks: { show: false }, font: "12px system-ui, sans-serif", ...more,
      });
      const options = {
        width: box.clientWidth, height, padding: [8, axes.length > 1 ? 0 : 72, 0, 0], cursor: { sync: { key: "velvet" }, y: false, points: { size: 6 } },
        legend: { live: true }, scales: { x: { time: false, range: () => [0, Math.max(data.seconds, end)] }, ...Object.fromEntries(axes.map((a) => [a.scale, { range: a.range }])) },
        axes: [axis({ size: 30, values: (_, ticks) => ticks.map((t) => `${t} s`) }),
          ...axes.map((a, n) => axis({ scale: a.scale, side: n ? 1 : 3, size: 72, space: 26, grid: { show: n === 0, stroke: css("--line"), width: 1 }, values: (_, ticks) => ticks.map((t) => `${t} ${a.unit}`) }))],
        series: [{ label: "time", value: (_, v) => (v === null ? "" : clock(v)) }, ...series.map((s) => ({
          label: s.label, scale: s.scale, width: s.width ?? 1.6, stroke: css(s.colour), dash: s.dash, points: { show: false },
          fill: s.fill ? `${css(s.colour)}${s.fill}` : undefined, value: (_, v) => (v === null ? "" : `${fixed(v, s.digits)} ${s.unit}`),
        }))],
      };
      plot = new uPlot(options, [time, ...series.map((s) => s.values)], box);
      plot.over.addEventListener("click", () => {
        const at = plot.posToVal(plot.cursor.left, "x");
        if (!Number.isFinite(at)) return;
        if (at < first || at > final) account.whole();
        setTime(at);
      });
      plot.setCursor({ left: cursor, top: 10 }, false);
    };
    build();
    onTheme.push(build);
    new ResizeObserver(() => { if (Math.abs(plot.width - box.clientWidth) > 1) plot.setSize({ width: box.clientWidth, height }); }).observe(box);
    charts.push({ mark: (s) => plot.setCursor({ left: plot.valToPos(s, "x"), top: 10 }, false) });
  };
  const fromZero = (_, least, most) => [Math.min(0, least ?? 0), (most || 1) * 1.08];
  const colours = ["--s1", "--s2", "--s3", "--s4", "--s5", "--s6"];

  chart("Tool speed", data.speed.time,
    [{ label: "tool", unit: "mm/s", digits: 1, scale: "mm/s", colour: "--s1", fill: "26", values: data.speed.tool }],
    [{ scale: "mm/s", unit: "mm/s", range: fromZero }]);
  if (data.power) {
    chart("Laser power", data.power.time,
      [{ label: "mean", unit: "%", digits: 1, scale: "%", colour: "--s3", fill: "33", width: 1, values: data.power.mean },
        { label: "highest", unit: "%", digits: 1, scale: "%", colour: "--s1", width: 1, values: data.power.highest }],
      [{ scale: "%", unit: "%", range: () => [0, 104] }], 150);
  }
  if (data.speed.filament.some((speed) => speed !== 0)) {
    chart("Filament speed", data.speed.time,
      [{ label: "filament", unit: "mm/s", digits: 2, scale: "mm/s", colour: "--s2", fill: "1c", width: 1.2, values: data.speed.filament }],
      [{ scale: "mm/s", unit: "mm/s", range: (_, least, most) => [Math.min(0, least) * 1.08, Math.max(most, 0.1) * 1.08] }], 150);
  }

  const { time, temperatures, duties, volts, cpu } = data.telemetry;
  if (temperatures.length) {
    const share = duties.filter((d) => temperatures.some((t) => t.name === d.name));
    chart("Temperature and heating power", time,
      [...share.map((d) => ({
        label: `${d.name} power`, unit: "%", digits: 0, scale: "%", width: 0.6, fill: "22",
        colour: colours[temperatures.findIndex((t) => t.name === d.name) % colours.length],
        values: d.values.map((v) => (v === null ? null : 100 * v)),
      })), ...temperatures.map((t, n) => ({ label: t.name, unit: "\u00b0C", digits: 1, scale: "\u00b0C", width: 2, colour: colours[n % colours.length], values: t.values }))],
      [{ scale: "\u00b0C", unit: "\u00b0C", range: fromZero }, ...(share.length ? [{ scale: "%", unit: "%", range: () => [0, 102] }] : [])]);
  }
  if (volts.length || cpu.length) {
    const supply = volts.flatMap((v) => booted(v.values));
    const lowest = Math.floor(supply.reduce((a, b) => Math.min(a, b), Infinity)) - 1;
    const highest = Math.ceil(largest(supply)) + 1;
    const busiest = Math.min(100, Math.max(10, 130 * largest(load)));
    chart("Supply and processor", time,
      [...cpu.map((c) => ({ label: "CPU load", unit: "%", digits: 1, scale: "%", colour: "--s3", fill: "22", width: 1, values: c.values.map((v) => (v === null ? null : 100 * v)) })),
        ...volts.map((v, n) => ({ label: v.name, unit: "V", digits: 2, scale: "V", colour: ["--s4", "--s5", "--s6"][n % 3], values: v.values }))],
      [...(volts.length ? [{ scale: "V", unit: "V", range: () => [Number.isFinite(lowest) ? lowest : 0, highest] }] : []), ...(cpu.length ? [{ scale: "%", unit: "%", range: () => [0, busiest] }] : [])]);
  }

  // --- time -----------------------------------------------------------------------------------------------------
  let now = end;
  let playing = false;
  let before = 0;
  const setTime = (seconds) => {
    now = Math.min(Math.max(seconds, first), final);
    $("time").value = (1000 * (now - first)) / (final - first || 1);
    $("clock").textContent = `${fixed(now, 1)} of ${fixed(end, 1)} s`;
    stage.show(now);
    for (const each of charts) each.mark(now);
  };
  const setPlaying = (on) => {
    playing = on;
    $("playicon").setAttribute("d", on ? "M5 3h4v14H5zM11 3h4v14h-4z" : "M5 3l12 7-12 7z");
    $("play").setAttribute("aria-label", on ? "Pause" : "Play");
    if (!on) return;
    if (now >= final) setTime(first);
    before = performance.now();
    requestAnimationFrame(step);
  };
  // However long the job, it is shown in a quarter of a minute.
  const step = (at) => {
    if (!playing) return;
    setTime(now + ((at - before) / 15000) * (final - first));
    before = at;
    if (now >= final) setPlaying(false); else requestAnimationFrame(step);
  };
  $("play").addEventListener("click", () => setPlaying(!playing));
  $("time").addEventListener("input", () => { setPlaying(false); setTime(first + ($("time").value / 1000) * (final - first)); });
  $("travel").addEventListener("change", () => stage.setTravel?.($("travel").checked));
  for (const input of document.querySelectorAll("input[name=paint]")) {
    input.addEventListener("change", () => { setLegend(); stage.repaint(); });
  }
  onTheme.push(() => stage.repaint());
  setLegend();
  isReady = true;
  stage.repaint();
  setTime(end);
})();
