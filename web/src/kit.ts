// What the shell carries for the second file as well: build.mjs sees to it that nothing is carried twice.
export * from "preact";
export * from "preact/hooks";
export { Fragment, jsx, jsxs } from "preact/jsx-runtime";
export { computed, effect, signal, useSignal, useSignalEffect } from "@preact/signals";
export * from "./api/link";
export * from "./api/types";
export * from "./state/history";
export * from "./state/machine";
export * from "./state/notices";
export * from "./state/prefs";
export * from "./state/route";
export * from "./state/session";
export * from "./shell/format";
export * from "./shell/icon";
export * from "./shell/parts";
export * from "./shell/login";
