// Made by web/build.mjs: path, content type, bytes (gzip). All but index.html have their hash in their name.
&[
    ("/index.html", "text/html; charset=utf-8", include_bytes!("index.html.gz")),
    ("/style-22bcfb5c07.css", "text/css; charset=utf-8", include_bytes!("style-22bcfb5c07.css.gz")),
    ("/shell-ab661b1460.js", "text/javascript; charset=utf-8", include_bytes!("shell-ab661b1460.js.gz")),
    ("/more-e55085ea7d.js", "text/javascript; charset=utf-8", include_bytes!("more-e55085ea7d.js.gz")),
    ("/views-9fc931c36e.css", "text/css; charset=utf-8", include_bytes!("views-9fc931c36e.css.gz")),
    ("/icon-fc64963e3b.svg", "image/svg+xml", include_bytes!("icon-fc64963e3b.svg.gz")),
]
