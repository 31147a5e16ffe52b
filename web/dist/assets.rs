// Made by web/build.mjs: path, content type, bytes (gzip). All but index.html have their hash in their name.
&[
    ("/index.html", "text/html; charset=utf-8", include_bytes!("index.html.gz")),
    ("/style-fcc776d373.css", "text/css; charset=utf-8", include_bytes!("style-fcc776d373.css.gz")),
    ("/shell-8a04c9ac02.js", "text/javascript; charset=utf-8", include_bytes!("shell-8a04c9ac02.js.gz")),
    ("/more-b735a8aea6.js", "text/javascript; charset=utf-8", include_bytes!("more-b735a8aea6.js.gz")),
    ("/views-2548e73e9d.css", "text/css; charset=utf-8", include_bytes!("views-2548e73e9d.css.gz")),
    ("/icon-fc64963e3b.svg", "image/svg+xml", include_bytes!("icon-fc64963e3b.svg.gz")),
    ("/settings-e7d4f24c2d.json", "application/json", include_bytes!("settings-e7d4f24c2d.json.gz")),
]
