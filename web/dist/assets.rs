// Made by web/build.mjs: path, content type, bytes (gzip). All but index.html have their hash in their name.
&[
    ("/index.html", "text/html; charset=utf-8", include_bytes!("index.html.gz")),
    ("/style-fcc776d373.css", "text/css; charset=utf-8", include_bytes!("style-fcc776d373.css.gz")),
    ("/shell-99aea7ccbf.js", "text/javascript; charset=utf-8", include_bytes!("shell-99aea7ccbf.js.gz")),
    ("/more-75c3e9b742.js", "text/javascript; charset=utf-8", include_bytes!("more-75c3e9b742.js.gz")),
    ("/views-c7567025ba.css", "text/css; charset=utf-8", include_bytes!("views-c7567025ba.css.gz")),
    ("/icon-fc64963e3b.svg", "image/svg+xml", include_bytes!("icon-fc64963e3b.svg.gz")),
    ("/settings-f15356de1f.json", "application/json", include_bytes!("settings-f15356de1f.json.gz")),
]
