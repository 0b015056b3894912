# Stage 1 builds one wheel with the browser client inside; stage 2 holds only what runs.
FROM python:3.11-slim AS build
WORKDIR /src
RUN pip install --no-cache-dir uv==0.13.9
COPY pyproject.toml uv.lock package.json package-lock.json build.mjs hatch_build.py README.md LICENSE ./
COPY server server
COPY study study
COPY migrations migrations
COPY web web
RUN uv export --quiet --locked --no-dev --no-emit-project --output-file requirements.txt \
 && uv build --wheel --out-dir wheels

FROM python:3.11-slim
ENV PYTHONUNBUFFERED=1 \
    VARIL_HOST=0.0.0.0 \
    VARIL_PORT=8000 \
    VARIL_CACHE_DIR=/data/cache
RUN useradd --create-home --home-dir /data --uid 10001 varil
COPY --from=build /src/requirements.txt /src/wheels/ /tmp/
RUN pip install --no-cache-dir --require-hashes --requirement /tmp/requirements.txt \
 && pip install --no-cache-dir --no-deps /tmp/varil-*.whl \
 && rm -rf /tmp/*
# Data, the secret key and the compiled kernels live below /data: mount a volume there.
WORKDIR /data
USER varil
EXPOSE 8000
HEALTHCHECK --interval=10s --timeout=3s --start-period=30s \
  CMD ["python", "-c", "import urllib.request; urllib.request.urlopen('http://127.0.0.1:8000/healthz', timeout=2)"]
CMD ["varil", "serve"]
