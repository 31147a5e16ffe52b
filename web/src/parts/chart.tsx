// Temperatures of the last ten minutes, live.
import { useEffect, useRef } from "preact/hooks";
import uPlot from "uplot";
import { effect } from "@preact/signals";
import { heaterLabel, num } from "../shell/format";
import { times, traces, traceTurn } from "../state/history";
import { colour, themeTurn } from "../state/prefs";

export const SHADES = ["s1", "s2", "s3", "s4", "s5", "s6"];

const hours = (time: number) => new Date(time * 1000).toLocaleTimeString([], { hour: "2-digit", minute: "2-digit" });

/** What was at the time under the pointer. */
function tip(names: string[]): uPlot.Plugin {
  const box = document.createElement("div");
  box.className = "charttip";
  box.hidden = true;
  return {
    hooks: {
      init: (chart) => { chart.over.append(box); },
      setCursor: (chart) => {
        const at = chart.cursor.idx;
        const time = at === null || at === undefined ? undefined : chart.data[0][at];
        box.hidden = time === undefined || (chart.cursor.left ?? -1) < 0;
        if (box.hidden || at === null || at === undefined || time === undefined) return;
        const rows = names.map((name, index) => {
          const row = document.createElement("span");
          const dot = document.createElement("i");
          dot.className = `dot ${SHADES[index % 6]}`;
          row.append(dot, `${heaterLabel(name)} ${num(chart.data[index * 2 + 1]?.[at], 1)} °C`);
          return row;
        });
        box.replaceChildren(new Date(time * 1000).toLocaleTimeString(), ...rows);
        const isRight = (chart.cursor.left ?? 0) > chart.over.clientWidth / 2;
        box.style.left = isRight ? "" : `${(chart.cursor.left ?? 0) + 14}px`;
        box.style.right = isRight ? `${chart.over.clientWidth - (chart.cursor.left ?? 0) + 14}px` : "";
      },
    },
  };
}

function options(names: string[], width: number, height: number): uPlot.Options {
  const quiet = colour("quiet");
  const line = colour("line");
  const axis: uPlot.Axis = { stroke: quiet, grid: { stroke: line, width: 1 }, ticks: { show: false }, font: "12px system-ui, sans-serif", gap: 6 };
  const series: uPlot.Series[] = [{}];
  names.forEach((name, index) => {
    const shade = colour(SHADES[index % 6] ?? "s1");
    series.push({ label: heaterLabel(name), stroke: shade, width: 2, points: { show: false } });
    series.push({ label: `${heaterLabel(name)} target`, stroke: shade, width: 1.2, dash: [4, 5], points: { show: false } });
  });
  return {
    width, height, series, legend: { show: false }, plugins: [tip(names)], padding: [8, 18, 0, 0],
    cursor: { points: { size: 7 }, drag: { x: false, y: false }, y: false },
    scales: { x: { time: true }, y: { range: (_, low, high) => [Math.min(20, Math.floor((low ?? 20) / 10) * 10), Math.max(60, (high ?? 60) * 1.06)] } },
    axes: [{ ...axis, space: 70, values: (_, all) => all.map(hours), size: 26 }, { ...axis, size: 38, values: (_, all) => all.map((value) => `${value}°`) }],
  };
}

function data(names: string[]): uPlot.AlignedData {
  const out: (number | null)[][] = [[...times]];
  const clean = (list: number[] | undefined, hideZero: boolean) => times.map((_, at) => {
    const value = list?.[at];
    return value === undefined || Number.isNaN(value) || (hideZero && value === 0) ? null : value;
  });
  for (const name of names) {
    const trace = traces.get(name);
    out.push(clean(trace?.temperatures, false), clean(trace?.targets, true));
  }
  return out as uPlot.AlignedData;
}

export function TemperatureChart({ names }: { names: string[] }) {
  const box = useRef<HTMLDivElement>(null);
  const key = names.join();
  useEffect(() => {
    const at = box.current!;
    let chart: uPlot | null = null;
    const make = () => {
      chart?.destroy();
      chart = new uPlot(options(names, at.clientWidth, at.clientHeight), data(names), at);
    };
    const stopTheme = effect(() => { themeTurn.value; make(); });
    const stopData = effect(() => { traceTurn.value; if (!document.hidden) chart?.setData(data(names)); });
    const watcher = new ResizeObserver(() => chart?.setSize({ width: at.clientWidth, height: at.clientHeight }));
    watcher.observe(at);
    return () => { stopTheme(); stopData(); watcher.disconnect(); chart?.destroy(); };
  }, [key]);
  return <div class="chart" ref={box} role="img" aria-label="Temperatures of the last minutes; the figures are in the table beside it" />;
}
