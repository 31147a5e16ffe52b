// Icons of one stroke, drawn on 24 by 24.
const PATHS = {
  machine: "M4 20V9l8-5 8 5v11M4 20h16M9 20v-6h6v6",
  job: "M12 3 4 7.5v9L12 21l8-4.5v-9zM4 7.5l8 4.5 8-4.5M12 12v9",
  files: "M4 6.5h6l2 2.5h8v10.5H4z",
  console: "m5 7 5 5-5 5M12 17h7",
  bed: "M3 16 12 20l9-4-9-4zM3 16v-3l9-4 9 4v3M8 11c1-4 3-5 4-2s3 2 4-2",
  work: "M12 3v18M3 12h18M12 7.5a4.5 4.5 0 1 0 0 9 4.5 4.5 0 0 0 0-9",
  settings: "M4 7h9m5 0h2M4 17h3m5 0h8M15.500 4.500v5M9.500 14.500v5",
  system: "M4 5h16v10H4zM9 20h6M12 15v5",
  stop: "M8.500 3h7L21 8.500v7L15.500 21h-7L3 15.500v-7zM8 12h8",
  theme: "M12 4a8 8 0 1 0 0 16zM12 4a8 8 0 0 1 0 16",
  home: "M4 11.500 12 5l8 6.500M6.500 10v9h11v-9",
  play: "M8 5.500v13l10.500-6.500z",
  pause: "M8.500 6v12M15.500 6v12",
  cancel: "M6.500 6.500l11 11M17.500 6.500l-11 11",
  up: "M12 19V5M6 11l6-6 6 6",
  down: "M12 5v14M6 13l6 6 6-6",
  left: "M19 12H5M11 6l-6 6 6 6",
  right: "M5 12h14M13 6l6 6-6 6",
  upload: "M12 16V5M7 9.500 12 4.500l5 5M5 19.500h14",
  download: "M12 4.500v11M7 11l5 5 5-5M5 19.500h14",
  trash: "M5 7h14M10 7V4.500h4V7M7 7l1 12.500h8L17 7",
  edit: "M5 19l1-4L16 5l3 3L9 18z",
  folder: "M4 6.500h6l2 2.500h8v10.500H4zM12 12v5M9.500 14.500h5",
  search: "M10.500 4.500a6 6 0 1 0 0 12 6 6 0 0 0 0-12M15 15l5 5",
  check: "M5 12.500l4.500 4.500L19 7.500",
  warn: "M12 4 2.800 20h18.400zM12 10v4.500M12 17v.2",
  info: "M12 4a8 8 0 1 0 0 16 8 8 0 0 0 0-16M12 11v5M12 8v.2",
  user: "M12 4.500a3.500 3.500 0 1 0 0 7 3.500 3.500 0 0 0 0-7M5 20c0-4 3-6 7-6s7 2 7 6",
  undo: "M8 5 4 9l4 4M4 9h10a5 5 0 0 1 0 10h-3",
  keys: "M3 7h18v10H3zM7 10.500h.1M11 10.500h.1M15 10.500h.1M8 14h8",
  fan: "M12 12c-6-1-6-7-1-8 3 0 3 4 1 8m0 0c6 1 6 7 1 8-3 0-3-4-1-8m0 0c-1 6-7 6-8 1 0-3 4-3 8-1m0 0c1-6 7-6 8-1 0 3-4 3-8 1",
  more: "M6 12h.1M12 12h.1M18 12h.1",
} as const;
export type IconName = keyof typeof PATHS;

export function Icon({ name }: { name: IconName }) {
  return (
    <svg class="icon" viewBox="0 0 24 24" aria-hidden="true">
      <path d={PATHS[name]} />
    </svg>
  );
}
