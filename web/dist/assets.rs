// Made by web/build.mjs: path, content type, bytes (gzip). All but index.html have their hash in their name.
&[
    ("/index.html", "text/html; charset=utf-8", include_bytes!("index.html.gz")),
    ("/style-4486b210e4.css", "text/css; charset=utf-8", include_bytes!("style-4486b210e4.css.gz")),
    ("/shell-6338aadd66.js", "text/javascript; charset=utf-8", include_bytes!("shell-6338aadd66.js.gz")),
    ("/more-5ab5d50961.js", "text/javascript; charset=utf-8", include_bytes!("more-5ab5d50961.js.gz")),
    ("/views-5e56e5665f.css", "text/css; charset=utf-8", include_bytes!("views-5e56e5665f.css.gz")),
    ("/icon-fc64963e3b.svg", "image/svg+xml", include_bytes!("icon-fc64963e3b.svg.gz")),
]
