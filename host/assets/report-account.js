// Where the time of the run went: draws the sections about it. What it shows on the stage it asks of `stage`.
"use strict";
function drawAccount({ account, prints, $, element, fixed, clock, css, onTheme }, stage) {
  const { times, slow, starved, counted } = account;
  // A machine without filament has no print moves, and no travel between them.
  if (!prints) for (const each of times.kinds) if (each.kind === "print") each.name = "moves";
  const share = (seconds, of) => (of > 0 ? `${fixed((100 * seconds) / of, seconds / of < 0.0995 ? 1 : 0)} %` : "");
  const plain = (place) => (place ? PLAIN[(place - 1) % PLAIN.length] : "#999");
  const swatch = (colour) => {
    const cell = element("td");
    cell.append(element("i", undefined, "swatch"));
    cell.firstChild.style.background = colour;
    return cell;
  };
  const bar = (part, colour) => {
    const cell = element("td", undefined, "bar");
    cell.append(element("i"));
    Object.assign(cell.firstChild.style, { width: `${100 * part}%`, background: colour });
    return cell;
  };
  const stack = (box, parts) => {
    const all = parts.reduce((sum, { seconds }) => sum + seconds, 0);
    for (const { seconds, colour, title } of parts) {
      if (!(seconds > 0.05 || seconds > 0.001 * all)) continue;
      const piece = element("i");
      Object.assign(piece.style, { flex: `${seconds} 0 0`, background: colour });
      piece.title = title;
      box.append(piece);
    }
  };
  const amount = (mm) => (Math.abs(mm) >= 1000 ? `${fixed(mm / 1000, 2)} m` : `${fixed(mm, 1)} mm`);

  // --- where time goes --------------------------------------------------------------------------------------------
  const inks = { print: "#a33a80", travel: "#1f7a8c", filament: "#b8901f", own: "#5b52b5", heating: "#c2651a", dwell: "#7a4a2a", pause: "#4a6fa5", standing: "#78808a" };
  stack($("spentbar"), times.kinds.map(({ kind, name, seconds }) => ({
    seconds, colour: inks[kind], title: `${name}: ${clock(seconds)}, ${share(seconds, times.seconds)}`,
  })));
  const row = (...cells) => {
    const node = element("tr");
    node.append(...cells);
    return node;
  };
  const spent = $("spentrows").tBodies[0];
  for (const { kind, name, seconds } of times.kinds) {
    if (seconds < 0.05) continue;
    spent.append(row(swatch(inks[kind]), element("td", name), element("td", clock(seconds), "n"), element("td", share(seconds, times.seconds), "n")));
  }
  const all = row(element("td"), element("td", "the whole job"), element("td", clock(times.seconds), "n"), element("td", "100 %", "n"));
  all.style.fontWeight = 600;
  spent.append(all);
  const pace = element("div", undefined, "pace");
  for (const [n, name] of [prints ? "Print moves" : "Moves", "Travel"].entries()) {
    const { cruising, accelerating, braking } = times.pace[n];
    const sum = cruising + accelerating + braking;
    if (!(sum > 0)) continue;
    const box = element("div", undefined, "stack");
    stack(box, [
      { seconds: cruising, colour: "#2a9d7c", title: "at even speed" }, { seconds: accelerating, colour: "#c2651a", title: "accelerating" },
      { seconds: braking, colour: "#a04040", title: "braking" },
    ]);
    pace.append(element("span", name), box, element("p", `${share(cruising, sum)} at even speed, ${share(accelerating, sum)} accelerating, ${share(braking, sum)} braking`));
  }
  $("pace").append(pace);
  if (times.untold >= 0.05) {
    $("untold").hidden = false;
    $("untold").textContent = `${clock(times.untold)} of motion could not be laid to lines of the program: it is in these sums, but in no layer, feature or object.`;
  }

  // --- layers -------------------------------------------------------------------------------------------------------
  const layers = times.layers.filter((layer) => layer.number > 0);
  const canvas = $("layerbars");
  if (layers.length < 2) $("layerscard").hidden = true;
  const [left, bottom, top] = [58, 24, 8];
  const most = layers.reduce((max, layer) => Math.max(max, layer.seconds), 0) || 1;
  let [chosen, pointed] = [-1, -1];
  const barAt = (event) => {
    const x = event.clientX - canvas.getBoundingClientRect().left - left;
    const n = Math.floor((x / (canvas.clientWidth - left)) * layers.length);
    return n >= 0 && n < layers.length ? n : -1;
  };
  const tell = (n) => {
    if (!layers.length) return;
    const before = times.layers.find((layer) => layer.number === 0);
    const around = before ? ` Before the first layer: ${clock(before.seconds)}.` : "";
    const longest = layers.reduce((a, b) => (b.seconds > a.seconds ? b : a), layers[0]);
    const layer = layers[n];
    $("layersay").textContent = layer
      ? `Layer ${layer.number}${layer.z === null ? "" : `, Z ${fixed(layer.z, 2)} mm`}: ${clock(layer.seconds)}${layer.waiting >= 0.05 ? `, ${clock(layer.waiting)} of it waiting` : ""}, ${amount(layer.filament)} of filament.`
      : `${layers.length} layers, ${clock(layers.reduce((sum, each) => sum + each.seconds, 0) / layers.length)} each on average; the longest is ${longest.number} with ${clock(longest.seconds)}.${around}`;
  };
  const drawLayers = () => {
    const ratio = window.devicePixelRatio || 1;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    if (!width || !layers.length) return;
    [canvas.width, canvas.height] = [width * ratio, height * ratio];
    const pen = canvas.getContext("2d");
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.font = "12px system-ui, sans-serif";
    const rise = height - bottom - top;
    const steps = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 30, 60, 120, 300, 600, 1200, 1800, 3600, 7200];
    const step = steps.find((each) => most / each <= 5) ?? most;
    pen.textAlign = "right"; pen.textBaseline = "middle";
    for (let at = 0; at <= most * 1.001; at += step) {
      const y = top + rise * (1 - at / most);
      pen.fillStyle = css("--line"); pen.fillRect(left, y, width - left, 1);
      pen.fillStyle = css("--quiet"); pen.fillText(step < 1 ? `${at.toFixed(1)} s` : step < 60 ? `${Math.round(at)} s` : `${Math.round(at / 60)} min`, left - 8, y);
    }
    const pitch = (width - left) / layers.length;
    const gap = pitch > 4 ? 1.5 : 0;
    layers.forEach((layer, n) => {
      const x = left + n * pitch;
      const tall = (seconds) => (rise * seconds) / most;
      pen.fillStyle = n === chosen ? css("--s3") : n === pointed ? css("--s2") : css("--accent");
      pen.fillRect(x, top + rise - tall(layer.seconds), Math.max(pitch - gap, 0.5), tall(layer.seconds));
      pen.fillStyle = "#9a93a3";
      pen.fillRect(x, top + rise - tall(layer.waiting), Math.max(pitch - gap, 0.5), tall(layer.waiting));
    });
    pen.fillStyle = css("--quiet"); pen.textBaseline = "alphabetic"; pen.textAlign = "center";
    const every = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000].find((each) => each * pitch >= 46) ?? 2000;
    layers.forEach((layer, n) => {
      if (layer.number % every === 0 || every === 1) pen.fillText(layer.number, left + (n + 0.5) * pitch, height - 6);
    });
  };
  const choose = (n) => {
    chosen = n;
    $("layerall").classList.toggle("on", n < 0);
    $("layer").value = n < 0 ? layers.length : n;
    $("layerat").textContent = n < 0 ? `${layers.length} layers` : `layer ${layers[n].number} of ${layers[layers.length - 1].number}`;
    tell(n);
    drawLayers();
    stage.window(n < 0 ? null : layers[n]);
  };
  canvas.addEventListener("mousemove", (event) => { pointed = barAt(event); tell(pointed < 0 ? chosen : pointed); drawLayers(); });
  canvas.addEventListener("mouseleave", () => { pointed = -1; tell(chosen); drawLayers(); });
  canvas.addEventListener("click", (event) => { const n = barAt(event); if (n >= 0) { choose(n); stage.look(); } });
  $("layer").max = layers.length;
  $("layer").addEventListener("input", () => { const n = +$("layer").value; choose(n < layers.length ? n : -1); });
  $("layerall").addEventListener("click", () => choose(-1));
  $("layerrow").hidden = layers.length < 2;
  $("layerrow").style.display = layers.length < 2 ? "none" : "";
  if (layers.length) new ResizeObserver(drawLayers).observe(canvas);
  onTheme.push(drawLayers);

  // --- objects, features ------------------------------------------------------------------------------------------
  const objects = times.objects.map((object, place) => ({ ...object, place })).filter((object) => object.name);
  const others = times.objects[0];
  const longest = Math.max(...times.objects.map((object) => object.seconds), 1e-9);
  for (const object of [...objects, ...(objects.length && others.seconds > 0 ? [{ ...others, place: 0, name: "of no object" }] : [])]) {
    const name = element("td", object.name);
    if (object.left_out) name.append(element("span", "left out", "tag"));
    $("objects").tBodies[0].append(row(swatch(plain(object.place)), name, element("td", clock(object.seconds), "n"),
      element("td", clock(object.printing), "n"), element("td", amount(object.filament), "n"), bar(object.seconds / longest, plain(object.place))));
  }
  if (!objects.length) $("objectscard").hidden = true;

  const features = [...times.features].sort((a, b) => b.seconds - a.seconds);
  const printing = features.reduce((sum, feature) => sum + feature.seconds, 0);
  for (const feature of features) {
    const colour = plain(feature.place);
    $("features").tBodies[0].append(row(swatch(colour), element("td", feature.name || "not named"), element("td", clock(feature.seconds), "n"),
      element("td", share(feature.seconds, printing), "n"), element("td", `${fixed(feature.length / feature.seconds, 1)} mm/s`, "n"),
      element("td", amount(feature.filament), "n"), bar(feature.seconds / features[0].seconds, colour)));
  }
  const isNamed = features.some((feature) => feature.name);
  if (!isNamed) $("featurescard").hidden = true;

  // --- slow places, planner ----------------------------------------------------------------------------------------
  const goTo = (from, to) => {
    const n = layers.findIndex((layer) => layer.from <= from && from <= layer.to);
    choose(n);
    stage.mark(from, to);
    stage.look();
  };
  for (const place of slow) {
    const lines = place.last > place.line ? `${place.line}\u2013${place.last}` : `${place.line}`;
    const first = element("td");
    first.append(element("button", lines));
    const code = element("td");
    code.append(element("code", place.text.length > 44 ? `${place.text.slice(0, 43)}\u2026` : place.text));
    const line = row(first, code, element("td", place.moves, "n"), element("td", place.layer || "", "n"), element("td", place.feature),
      element("td", `${fixed(place.speed, 1)} mm/s`, "n"), element("td", `${fixed(place.asked, 0)} mm/s`, "n"), element("td", `${fixed(place.lost, place.lost < 10 ? 2 : 0)} s`, "n"));
    line.addEventListener("click", () => goTo(place.from, place.to));
    $("slow").tBodies[0].append(line);
  }
  if (!slow.length) $("slowcard").hidden = true;

  const said = counted === null ? "" : counted === 0 ? " The planner itself counted none either." : ` The planner itself counted ${counted} moves with too little look-ahead behind them.`;
  $("planner").textContent = starved === null
    ? "Whether motion waited for the planner is not known: the run could not be laid along its program."
    : (starved.count === 0 ? "None: motion never stood or braked to rest where the program does not ask for it." : `${starved.count} times motion stood or braked to rest though the program asks for no stop, ${fixed(starved.seconds, 2)} s in all:`) + said;
  for (const stop of starved?.first ?? []) {
    const what = stop.stood > 0 ? `stood ${fixed(1000 * stop.stood, 0)} ms` : "braked to rest";
    const line = row(element("td", `${fixed(stop.at, 2)} s`), element("td", what), element("td", stop.line === null ? "" : `before line ${stop.line}`));
    line.addEventListener("click", () => goTo(stop.at, stop.at));
    $("starved").tBodies[0].append(line);
  }
  if (!starved?.count) $("starved").hidden = true;

  // --- what is made at a time ---------------------------------------------------------------------------------------
  const { labels } = account;
  const count = labels.length / 4;
  const labelAt = (seconds) => {
    let [a, b] = [0, count];
    while (a < b) { const middle = (a + b) >> 1; if (labels[4 * middle] <= seconds) a = middle + 1; else b = middle; }
    return a ? { layer: labels[4 * a - 3], feature: labels[4 * a - 2], object: labels[4 * a - 1] } : { layer: 0, feature: 0, object: 0 };
  };
  const names = {
    feature: isNamed ? features.filter((feature) => feature.name).map(({ name, place }) => ({ name, colour: plain(place) })) : [],
    object: objects.filter((object) => !object.left_out || object.seconds > 0).map(({ name, place }) => ({ name, colour: plain(place) })),
  };
  choose(-1);
  return { labelAt, plain, names, isWhole: () => chosen < 0, whole: () => choose(-1) };
}
