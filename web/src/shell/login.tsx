// Who may not see anything yet: login, or the first password, which the machine's own code confirms.
import { useSignal } from "@preact/signals";
import { call } from "../api/link";
import type { PasswordStep } from "../api/types";
import { hostname } from "../state/machine";
import { access, login, wantsLogin } from "../state/session";
import { Button, Dialog } from "./parts";

function LoginForm() {
  const error = useSignal<string | null>(null);
  const busy = useSignal(false);
  const submit = async (event: Event) => {
    event.preventDefault();
    const form = new FormData(event.currentTarget as HTMLFormElement);
    busy.value = true;
    error.value = await login(String(form.get("username")), String(form.get("password")));
    busy.value = false;
  };
  return (
    <form class="form" onSubmit={submit}>
      <input class="unseen" type="text" name="username" value="owner" autocomplete="username" tabIndex={-1} aria-hidden="true" readOnly />
      <label>Password<input type="password" name="password" autocomplete="current-password" required /></label>
      {error.value && <p class="wrong" role="alert">{error.value}</p>}
      <Button kind="main" submit disabled={busy.value}>Log in</Button>
    </form>
  );
}

/** Setting a password, first or new: typed twice, then confirmed by a code that only who stands at the machine can read. */
export function PasswordForm({ onDone }: { onDone?: () => void }) {
  const step = useSignal<PasswordStep | null>(null);
  const error = useSignal<string | null>(null);
  const word = useSignal("");
  const first = async (event: Event) => {
    event.preventDefault();
    const form = new FormData(event.currentTarget as HTMLFormElement);
    const password = String(form.get("password"));
    if (password.length < 8) error.value = "Take eight characters or more.";
    else if (password !== form.get("again")) error.value = "The two are not the same.";
    else {
      error.value = null;
      try {
        const answer = await call("velvet.password.set", { password });
        word.value = password;
        if (answer !== "ok") step.value = answer;
        else {
          error.value = await login("owner", password);
          if (!error.value) onDone?.();
        }
      } catch (refused) { error.value = (refused as Error).message; }
    }
  };
  const second = async (event: Event) => {
    event.preventDefault();
    const code = String(new FormData(event.currentTarget as HTMLFormElement).get("code")).trim();
    try {
      await call("velvet.password.set", { code });
      error.value = await login("owner", word.value);
      if (!error.value) onDone?.();
    } catch (refused) { error.value = (refused as Error).message; }
  };
  const wrong = error.value && <p class="wrong" role="alert">{error.value}</p>;
  if (step.value) {
    return (
      <form class="form" onSubmit={second}>
        <p>The machine shows a code of six digits on its {step.value.shown_on}. Type it here within {Math.round(step.value.expires_s / 60)} minutes.</p>
        <label>Code<input class="code" name="code" inputMode="numeric" autocomplete="one-time-code" maxLength={6} required /></label>
        {wrong}
        <Button kind="main" submit>Confirm</Button>
      </form>
    );
  }
  return (
    <form class="form" onSubmit={first}>
      <input class="unseen" type="text" name="username" value="owner" autocomplete="username" tabIndex={-1} aria-hidden="true" readOnly />
      <label>New password<input type="password" name="password" autocomplete="new-password" required /></label>
      <label>Once more<input type="password" name="again" autocomplete="new-password" required /></label>
      {wrong}
      <Button kind="main" submit>Set the password</Button>
    </form>
  );
}

export function Gate() {
  const isFirst = access.value?.password_set === false;
  return (
    <main class="gate">
      <section class="card">
        <p class="brand">Velvet</p>
        <h1>{isFirst ? "Choose a password" : hostname.value}</h1>
        <p class="quiet">
          {isFirst
            ? "Nobody has set one yet. Until then this machine shows and does nothing over the network."
            : "This machine lets in who has its password."}
        </p>
        {isFirst ? <PasswordForm /> : <LoginForm />}
        <p class="note">The connection is not encrypted: use it in networks that you trust.</p>
      </section>
    </main>
  );
}

export function LoginDialog() {
  if (!wantsLogin.value) return null;
  return <Dialog title="Log in" onClose={() => { wantsLogin.value = false; }}><LoginForm /></Dialog>;
}
