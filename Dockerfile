# vanelock with CHOLMOD on Debian 12, in the versions of requirements.lock:
#   docker build --tag vanelock .
#   docker run --rm --volume "$PWD:/study" --user "$(id -u):$(id -g)" vanelock run my.toml

FROM debian:bookworm-slim AS build
# hadolint ignore=DL3008
RUN apt-get update && apt-get install --yes --no-install-recommends \
      ca-certificates gcc git libc6-dev libsuitesparse-dev python3-dev python3-venv
WORKDIR /source
COPY . .
RUN grep --only-matching '^[^ ]*==[^ ]*' requirements.lock > /pins.txt \
 && python3 -m venv /opt/vanelock \
 && /opt/vanelock/bin/pip install --no-cache-dir --constraint /pins.txt '.[cholmod]'

FROM debian:bookworm-slim
# The first twelve are what tools/system_packages.py looks for (a test).
# hadolint ignore=DL3008
RUN apt-get update && apt-get install --yes --no-install-recommends \
      libegl1 libfontconfig1 libgl1 libglu1-mesa libgomp1 libx11-6 libxcursor1 libxext6 \
      libxfixes3 libxft2 libxinerama1 libxrender1 \
      libcholmod3 libopenblas0-pthread python3 \
 && rm -rf /var/lib/apt/lists/* \
 && useradd --create-home --uid 1000 vanelock \
 && install --directory --mode 1777 /study /var/cache/vanelock
COPY --from=build /opt/vanelock /opt/vanelock
# For any user: where compiled functions and settings of libraries go.
ENV PATH=/opt/vanelock/bin:$PATH HOME=/var/cache/vanelock NUMBA_CACHE_DIR=/var/cache/vanelock
USER 1000
WORKDIR /study
ENTRYPOINT ["vanelock"]
CMD ["--help"]
