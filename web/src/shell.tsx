// The first file: connection, state and frame of the page. All views come with the second one (more.tsx).
import { render } from "preact";
import { App } from "./shell/app";
import { startHistory } from "./state/history";
import { start } from "./state/session";

export * from "./kit";

startHistory();
start();
render(<App />, document.getElementById("app")!);
