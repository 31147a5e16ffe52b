// Made by web/build.mjs: path, content type, bytes (gzip). All but index.html have their hash in their name.
&[
    ("/index.html", "text/html; charset=utf-8", include_bytes!("index.html.gz")),
    ("/style-fcc776d373.css", "text/css; charset=utf-8", include_bytes!("style-fcc776d373.css.gz")),
    ("/shell-d9f2cbc730.js", "text/javascript; charset=utf-8", include_bytes!("shell-d9f2cbc730.js.gz")),
    ("/more-1a2cb92f36.js", "text/javascript; charset=utf-8", include_bytes!("more-1a2cb92f36.js.gz")),
    ("/views-25b54fecbc.css", "text/css; charset=utf-8", include_bytes!("views-25b54fecbc.css.gz")),
    ("/icon-fc64963e3b.svg", "image/svg+xml", include_bytes!("icon-fc64963e3b.svg.gz")),
    ("/settings-098c0d73d9.json", "application/json", include_bytes!("settings-098c0d73d9.json.gz")),
]
