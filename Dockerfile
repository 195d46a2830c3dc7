# fbptr as a container: built in one stage, run in another that holds the program and nothing of the build.
#
#   docker build -t fbptr .
#   docker run --rm -p 1234:1234 -p 127.0.0.1:9100:9100 --memory 2g --read-only -v wall:/data fbptr
#
# Without the window: the program needs the C library alone. Both stages are Debian 12, so that it is the same one. A
# release takes the program of its archives, which `.ci/release/build` made (`.ci/release/image`): PROGRAM=packed.

ARG PROGRAM=build

FROM rust:1-slim-bookworm AS build
WORKDIR /src
COPY . .
RUN cargo build --release --locked --no-default-features --features cli --bin fbptr \
    && install -s -m 755 target/release/fbptr /fbptr \
    && install -d -m 750 /data

FROM scratch AS packed
COPY target/packed/x86_64-unknown-linux-gnu/fbptr /fbptr
WORKDIR /data

FROM ${PROGRAM} AS program

FROM debian:bookworm-slim
COPY --from=program /fbptr /usr/local/bin/fbptr
COPY --from=program --chown=65532:65532 /data /data
USER 65532:65532
VOLUME /data
EXPOSE 1234 9100
STOPSIGNAL SIGTERM
ENTRYPOINT ["/usr/local/bin/fbptr"]
CMD ["serve", "--headless", "--size", "1280x720", "--listen", "0.0.0.0:1234", "--allow-remote", "--max-conns", "1000", "--max-conns-per-address", "16", "--idle-timeout", "300", "--metrics", "0.0.0.0:9100", "--snap-dir", "/data", "--snap-every", "1m", "--snap-keep", "1G"]
