// Made by web/build.mjs: path, content type, bytes (gzip). All but index.html have their hash in their name.
&[
    ("/index.html", "text/html; charset=utf-8", include_bytes!("index.html.gz")),
    ("/style-530c6fecaf.css", "text/css; charset=utf-8", include_bytes!("style-530c6fecaf.css.gz")),
    ("/shell-e5a2d57db2.js", "text/javascript; charset=utf-8", include_bytes!("shell-e5a2d57db2.js.gz")),
    ("/more-3999ae948a.js", "text/javascript; charset=utf-8", include_bytes!("more-3999ae948a.js.gz")),
    ("/icon-fc64963e3b.svg", "image/svg+xml", include_bytes!("icon-fc64963e3b.svg.gz")),
]
