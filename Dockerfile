# makeup-video on the CPU.
#
#   docker build -t makeup-video .
#   docker run --rm -v "$PWD:/films" makeup-video in.mp4 --ref look.jpg -o out.mp4
#   docker run --rm -p 127.0.0.1:8760:8760 makeup-video demo --host 0.0.0.0 --no-browser
#
# Outputs belong to user 1000; add --user "$(id -u):$(id -g)" for another one.

FROM python:3.12-slim-bookworm AS wheel
WORKDIR /source
COPY . .
RUN pip wheel --no-cache-dir --no-deps -w /wheel .

FROM python:3.12-slim-bookworm
# PoCL needs the system's linker to compile the kernels that paint.
RUN apt-get update \
    && apt-get install -y --no-install-recommends binutils \
    && rm -rf /var/lib/apt/lists/*
COPY --from=wheel /wheel /wheel
RUN pip install --no-cache-dir /wheel/*.whl && rm -r /wheel
RUN useradd --create-home --uid 1000 painter
# Any user of the container may compile kernels here; a volume keeps them between runs.
ENV POCL_CACHE_DIR=/var/cache/makeup-video
RUN install -d -m 0777 "$POCL_CACHE_DIR" && install -d -o painter /films
USER painter
WORKDIR /films
VOLUME /films
EXPOSE 8760
ENTRYPOINT ["makeup-video"]
CMD ["--help"]
