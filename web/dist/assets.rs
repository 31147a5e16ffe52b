// Made by web/build.mjs: path, content type, bytes (gzip). All but index.html have their hash in their name.
&[
    ("/index.html", "text/html; charset=utf-8", include_bytes!("index.html.gz")),
    ("/style-fcc776d373.css", "text/css; charset=utf-8", include_bytes!("style-fcc776d373.css.gz")),
    ("/shell-a1b5e049b8.js", "text/javascript; charset=utf-8", include_bytes!("shell-a1b5e049b8.js.gz")),
    ("/more-58d9d5fd4f.js", "text/javascript; charset=utf-8", include_bytes!("more-58d9d5fd4f.js.gz")),
    ("/views-2548e73e9d.css", "text/css; charset=utf-8", include_bytes!("views-2548e73e9d.css.gz")),
    ("/icon-fc64963e3b.svg", "image/svg+xml", include_bytes!("icon-fc64963e3b.svg.gz")),
    ("/settings-098c0d73d9.json", "application/json", include_bytes!("settings-098c0d73d9.json.gz")),
]
