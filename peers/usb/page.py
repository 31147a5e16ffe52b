"""What came of the cases: summary.json for programs, report.html for people."""

import html
import json
import os

STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; color: #1a1f24; background: #f6f7f8; margin: 0; }
main { max-width: 66rem; margin: 2rem auto; padding: 0 1.5rem; }
h1 { font-size: 1.6rem; margin-bottom: .2rem; }
h2 { font-size: 1.1rem; margin-top: 2rem; }
.lead { color: #4a545e; }
.counts span { display: inline-block; padding: .2rem .8rem; margin-right: .5rem; border-radius: 1rem; background: #fff; border: 1px solid #d8dde2; }
table { border-collapse: collapse; table-layout: fixed; width: 100%; background: #fff; border: 1px solid #d8dde2; }
th, td { text-align: left; padding: .45rem .8rem; border-top: 1px solid #e6eaed; vertical-align: top; overflow-wrap: anywhere; }
th { background: #eef1f3; border-top: 0; font-weight: 600; }
th:nth-child(1) { width: 28%; } th:nth-child(2) { width: 5rem; } th:nth-child(4) { width: 4.5rem; }
th.time, td.time { text-align: right; color: #4a545e; white-space: nowrap; }
.none { color: #8a949e; }
.ok, .passed { color: #12703a; font-weight: 600; } .failed { color: #b3261e; font-weight: 600; } .skipped { color: #8a6100; font-weight: 600; }
"""

# What the groups are about.
GROUPS = {
    "plug": "The plug itself, with another image: a serial port made of other people's crates",
    "board": "The image: its functions",
    "card": "The image: its card as a drive",
    "download": "The image: new firmware over USB",
    "print": "The image: prints",
}


def earlier(out, image, rows, names):
    """The rows of all cases that have been tried with this image, the latest attempt of each, in the order of the names."""
    path, found = os.path.join(out, "summary.json"), {}
    if os.path.exists(path):
        with open(path) as file:
            before = json.load(file)
        if before.get("image") == image:
            found = {row["name"]: row for row in before["cases"]}
    found.update({row["name"]: row for row in rows})
    return [found[name] for name in names if name in found]


def write(out, image, rows, versions):
    """`image`: its name and the SHA-256 of its file."""
    count = lambda ok: sum(row["ok"] is ok for row in rows)
    counts = {"passed": count(True), "failed": count(False), "skipped": count(None)}
    with open(os.path.join(out, "summary.json"), "w") as file:
        json.dump({"image": image, "cases": rows, **counts, "versions": versions}, file, indent=1)
    words = {True: "ok", False: "failed", None: "skipped"}
    with open(os.path.join(out, "report.html"), "w") as page:
        page.write(f"<!doctype html><html lang=en><meta charset=utf-8><title>The board at a real Linux</title><style>{STYLE}</style><main>\n")
        page.write("<h1>The board at a real Linux</h1><p class=lead>The unmodified image on the virtual board, plugged into Linux in QEMU over usbredir, or imported by "
                   "usbip. Its drivers, its tools and people's programs are the judges; what the machine did is seen by the virtual board, whatever the image believes.</p>\n")
        page.write(f"<p class=lead>Every row is of the image whose SHA-256 begins with {html.escape(image)}.</p>\n")
        of = lambda word: f"<span class={word if counts[word] or word == 'passed' else 'none'}>{counts[word]} {word}</span>"
        page.write("<p class=counts>" + "".join(map(of, ("passed", "failed", "skipped"))) + "</p>\n")
        for group in dict.fromkeys(row["name"].split(": ")[0] for row in rows):
            page.write(f"<h2>{html.escape(GROUPS.get(group, group))}</h2><table><tr><th>case<th>result<th>what came of it<th class=time>took\n")
            for row in rows:
                head, _, name = row["name"].partition(": ")
                if head == group:
                    word = words[row["ok"]]
                    page.write(f"<tr><td>{html.escape(name)}<td class={word}>{word}<td>{html.escape(row['figure'] or row['why'])}<td class=time>{row['seconds']:.0f} s\n")
            page.write("</table>\n")
        if versions:
            page.write("<h2>With these versions</h2><p class=lead>" + ", ".join(f"{html.escape(name)}&nbsp;{html.escape(version)}" for name, version in versions.items()) + "</p>\n")
        page.write("</main></html>\n")
