# Every entry a person needs; `make help` lists them. Compilers are found or installed by scripts/toolchain.sh.
.DEFAULT_GOAL := help
SHELL := /bin/sh
MAKEFLAGS += --no-print-directory

# One place for build products, whatever the environment says: the documentation names these paths.
export CARGO_TARGET_DIR := $(CURDIR)/target

# `make test` says the same of the same tree every time. `cargo test` draws new cases at every run, and
# `make test PROPTEST_RNG_SEED=7` other ones.
export PROPTEST_RNG_SEED ?= 1

TRIPLE := thumbv7em-none-eabihf
IMAGE := target/$(TRIPLE)/release/firmware
CONTROLLER := target/$(TRIPLE)/release/controller
BOOT_STAGE := target/$(TRIPLE)/release/boot
VELVET := target/native/velvet
VPRIME := virtual-prime/target/release/virtual-prime

CONFIG ?= config/samples/cartesian.ini
OUT ?= out/run
BOARD ?= virtual
ELF ?= $(IMAGE)

ifeq ($(filter help clean,$(or $(MAKECMDGOALS),help)),)
-include target/toolchain.mk
endif

.PHONY: help demo test firmware seal run compare console check macros klipper-files klippy bench budget faults updates fuzz peers peers-senders peers-network peers-slicers peers-fuzz usb usb-fuzz net net-fuzz stream replay velvet emulator virtual-prime clean
.PHONY: web page test-web test-page
.PHONY: test-lint test-desk test-host test-builds test-image test-virtual

help:
	@sed -n 's/^## //p' Makefile

target/toolchain.mk: scripts/toolchain.sh Cargo.toml
	@scripts/toolchain.sh $@

## make demo [NET=1]             print a real part on the virtual board, and a report to look at; NET=1: watch it print in a browser
demo: target/toolchain.mk
	@$(MAKE) -j2 virtual-prime firmware
	@MAKE="$(MAKE)" scripts/demo$(if $(NET),-net).sh

## make test                     every test: host crates, scenarios, the image on the virtual board
test: target/toolchain.mk
	@$(MAKE) -j2 test-desk test-builds
	@$(MAKE) -j2 test-image test-virtual
	@$(MAKE) test-page
	@echo "all tests passed"

## make firmware                 boot stage and image: target/thumbv7em-none-eabihf/release/firmware, all of it as plain bytes in
##                               firmware.bin beside it, and for a card flashme.bin; the image for a Klipper host, controller, with
##                               controller.bin and controller.card/flashme.bin
firmware: target/toolchain.mk
	@$(FW_CARGO) build -q --locked -p firmware -p controller -p boot --release --target $(TRIPLE) $(FW_FLAGS)
	@for image in $(IMAGE) $(CONTROLLER) $(BOOT_STAGE); do \
	    $(CARGO) run -q --locked -p xtask -- itcm $$image && $(CARGO) run -q --locked -p xtask -- paths $$image || exit 1; \
	done
	@$(CARGO) run -q --locked -p xtask -- seal $(IMAGE) $(BOOT_STAGE)
	@$(CARGO) run -q --locked -p xtask -- seal $(CONTROLLER) $(BOOT_STAGE)

# What cargo has linked made fit to be flashed; scripts/on-board.sh calls it.
seal: target/toolchain.mk
	@$(FW_CARGO) build -q --locked -p boot --release --target $(TRIPLE) $(FW_FLAGS)
	@$(CARGO) run -q --locked -p xtask -- seal "$(ELF)" $(BOOT_STAGE)

## make web                      the page that the board serves, web/dist, from its sources, and its check; needs npm
web:
	@cd web && npm ci --no-audit --no-fund && npm run --silent build && npm run --silent check

## make page [QUICK=1] [ONLY=name]    the page in a browser, from the unmodified image on the virtual board: each function, and pictures in out/page;
##                               needs npm and Chromium
page: virtual-prime firmware
	@cd web && { test -x node_modules/.bin/esbuild || npm ci --silent --no-audit --no-fund --prefer-offline; }
	@node web/tests/board.mjs "$(VPRIME)" "$(IMAGE)" out/page $(if $(QUICK),--quick) $(if $(ONLY),"$(ONLY)")

## make velvet                   the program for the desk, target/native/velvet: check, send, flash, sign, verify...
velvet: target/toolchain.mk
	@$(CARGO) build -q --locked -p host --profile native

# The emulator's release with our patches, where virtual-prime/Cargo.toml looks for it.
emulator: target/toolchain.mk
	@CARGO_TARGET_DIR=virtual-prime/target $(VP_CARGO) run -q --locked --manifest-path virtual-prime/emulator/Cargo.toml

virtual-prime: emulator
	@test -x $(VPRIME) || echo "building the virtual board, about four minutes the first time"
	@cd virtual-prime && CARGO_TARGET_DIR=target $(VP_CARGO) build -q --locked --release --ignore-rust-version

## make run CONFIG=f.ini GCODE=f.gcode OUT=dir [BOARD=virtual|native] [UNTIL=seconds] [VERIFY=1] [ELF=image [START=seconds]]
##                               a headless job on the virtual board, or on the fast host runner; ELF is another image,
##                               to which the operator speaks after its first words, or at START
run: velvet $(if $(filter native,$(BOARD)),,virtual-prime $(if $(filter $(IMAGE),$(ELF)),firmware))
	@test -n "$(GCODE)" || { echo "make run: say which G-code with GCODE=file"; exit 2; }
	@CONFIG="$(CONFIG)" GCODE="$(GCODE)" OUT="$(OUT)" BOARD="$(BOARD)" UNTIL="$(UNTIL)" ELF="$(ELF)" IMAGE="$(IMAGE)" START="$(START)" VERIFY="$(VERIFY)" scripts/run.sh

## make compare GCODE=f.gcode [CONFIG=f.ini]    the same job on both boards: every step must be the same (slow)
compare: velvet virtual-prime firmware
	@test -n "$(GCODE)" || { echo "make compare: say which G-code with GCODE=file"; exit 2; }
	@CONFIG="$(CONFIG)" GCODE="$(GCODE)" OUT="$(if $(filter out/run,$(OUT)),out/compare,$(OUT))" UNTIL="$(UNTIL)" ELF="$(ELF)" IMAGE="$(IMAGE)" scripts/compare.sh

## make console [CONFIG=f.ini] [ELF=image [START=seconds]] [USB=1 [USBREDIR_PORT=n] [USBIP_PORT=n]] [NET=1 | TAP=name]
##                               a live prompt on the virtual board; USB=1 offers its USB socket to QEMU and to Linux, NET=1 its
##                               consoles over the network to telnet on this computer, TAP its cable to a network device
console: virtual-prime $(if $(filter $(IMAGE),$(ELF)),firmware)
	@$(VPRIME) console --elf "$(ELF)" --config "$(if $(NET)$(TAP),$$(scripts/with-network.sh "$(CONFIG)"),$(CONFIG))" \
	    $(if $(NET),--net --telnet-port 23 --telnet-port 2323 --web-port 80) $(if $(TAP),--tap "$(TAP)") $(if $(filter $(IMAGE),$(ELF)),,--foreign) $(if $(START),--start $(START)) \
	    $(if $(USB),--usb $(if $(USBREDIR_PORT),--usbredir-port $(USBREDIR_PORT)) $(if $(USBIP_PORT),--usbip-port $(USBIP_PORT)))

## make check CONFIG=f.ini [JSON=1]              the configuration checker
check: velvet
	@$(VELVET) check "$(CONFIG)" $(if $(JSON),--json)

## make bench                    the performance ledger: instructions per step, per line, per interrupt, memory; some 18 minutes
bench: firmware virtual-prime velvet
	@$(CARGO) run -q --locked -p xtask -- ledger $(IMAGE) $(VPRIME) $(VELVET)

## make budget                   whether the image keeps within bench/budget.toml; some four minutes, and a part of make test
budget: firmware emulator
	@test -x $(VPRIME) || $(MAKE) virtual-prime
	@echo "== limits of the image"
	@$(CARGO) run -q --locked -p xtask -- budget $(IMAGE) $(VPRIME)

## make peers                    other people's programs beside ours: LinuxCNC's interpreter (Debian's linuxcnc-uspace)
peers: target/toolchain.mk
	@$(CARGO) build -q --locked -p host
	@python3 peers/rs274.py target/debug/velvet out/peers

## make peers-senders [SENDERS="printcore bcnc ..."]              printrun, OctoPrint, bCNC, CNCjs at the virtual board; installs them
peers-senders: virtual-prime firmware
	@python3 peers/senders/run.py target/peers out/peers/senders $(SENDERS)

## make peers-network            Debian's ping, telnet, nc, nmap and avahi at the virtual board, on a TAP device in a namespace of its own; root
peers-network: virtual-prime firmware
	@python3 peers/network/run.py out/peers/network

## make usb [ONLY=case] [GCODE=f.gcode]   the image at a real Linux: Debian's kernel and tools in QEMU, printrun; half an hour
usb: virtual-prime firmware
	@cd virtual-prime/images && CARGO_TARGET_DIR=../target/images $(FW_CARGO) build -q --locked --release $(FW_FLAGS)
	@GCODE="$(GCODE)" python3 peers/usb/run.py target/peers out/usb $(IMAGE) $(if $(ONLY),"$(ONLY)")

## make net                      the network: a day of the stack, nonsense frames for minutes, and the image at a cable; half an hour
net: virtual-prime firmware
	@$(CARGO) test -q --locked --release -p net -- --include-ignored
	@cd virtual-prime && CARGO_TARGET_DIR=target VELVET_ELF="$(CURDIR)/$(IMAGE)" \
	    $(VP_CARGO) test -q --locked --release --ignore-rust-version --test board -- network:: other_stacks:: --include-ignored

## make net-fuzz [ROUNDS=n] [SEED=n]       frames and answers that make no sense, to the stack at the desk; an hour if not said otherwise
net-fuzz:
	@set -e; first=$(if $(SEED),$(SEED),1000); end=$$((first + $(if $(ROUNDS),$(ROUNDS),3600))); \
	for seed in $$(seq $$first 100 $$((end - 1))); do \
	    left=$$((end - seed)); [ $$left -le 100 ] || left=100; \
	    NET_SEED=$$seed NET_ROUNDS=$$left $(CARGO) test -q --locked --release -p net -- fuzz::many --ignored; \
	done

## make usb-fuzz [SECONDS=n] [SEED=n]      requests of any kind at the image's USB socket, for an hour if not said otherwise, and a hundred cables
##                               pulled out while it works
usb-fuzz: virtual-prime firmware
	@cd virtual-prime && CARGO_TARGET_DIR=target VELVET_ELF="$(CURDIR)/$(IMAGE)" VELVET_FUZZ_SECONDS="$(SECONDS)" VELVET_FUZZ_SEED="$(SEED)" \
	    $(VP_CARGO) test -q --locked --release --ignore-rust-version -- usb::fuzz usb::replug --ignored --nocapture

## make faults [ONLY=class]      every fault of docs/safety.md in every state, and the power cut at every block write of a job: a page in
##                               out/faults; half an hour. ONLY: classes whose names hold this
faults: virtual-prime firmware
	@CARGO="$(CARGO)" VP_CARGO="$(VP_CARGO)" IMAGE="$(IMAGE)" ONLY="$(ONLY)" scripts/faults.sh

## make updates [ONLY=row]       every row of the table in docs/updates.md, the power cut at every erase and word; an hour
updates: virtual-prime firmware
	@cd virtual-prime && CARGO_TARGET_DIR=target VELVET_ELF="$(CURDIR)/$(IMAGE)" UPDATES_ONLY="$(ONLY)" \
	    $(VP_CARGO) test -q --locked --release --ignore-rust-version --test board -- updates:: --ignored --nocapture

## make stream                   100,000 lines by character counting at 1 Mbaud on the virtual board; some minutes
stream: virtual-prime firmware
	@cd virtual-prime && CARGO_TARGET_DIR=target VELVET_ELF="$(CURDIR)/$(IMAGE)" \
	    $(VP_CARGO) test -q --locked --release --ignore-rust-version stream:: -- --ignored --nocapture

## make replay                   every session recorded on Smoothieware v2, on the virtual board; some minutes
replay: virtual-prime firmware
	@cd virtual-prime && CARGO_TARGET_DIR=target VELVET_ELF="$(CURDIR)/$(IMAGE)" \
	    $(VP_CARGO) test -q --locked --release --ignore-rust-version v2_replay:: -- --include-ignored --nocapture

## make peers-slicers            files made by PrusaSlicer, Slic3r, CuraEngine and FreeCAD (Debian's), end to end on the native runner
peers-slicers: velvet
	@python3 peers/slicers.py $(VELVET) target/peers out/peers/slicers

## make peers-fuzz [SECONDS=n] [SEED=n]   random programs through LinuxCNC's interpreter and ours
peers-fuzz: velvet
	@python3 peers/fuzz_rs274.py $(VELVET) out/peers/fuzz $(or $(SECONDS),60) $(SEED)

## make fuzz [SECONDS=n] [TARGET=parser|program|console|http|websocket|form|json|klipper] [MINIMISE=1]
##                               any input: no panic, no hang, no motion outside limits; needs a C++ compiler
fuzz: target/toolchain.mk
	@CARGO="$(CARGO)" SECONDS_EACH="$(SECONDS)" TARGET="$(TARGET)" MINIMISE="$(MINIMISE)" scripts/fuzz.sh

## make macros DIR=folder        Klipper's macros of all .cfg files in a folder through Jinja2 and through ours; installs Jinja2 from PyPI
macros: target/toolchain.mk
	@test -n "$(DIR)" || { echo "make macros: say which folder with DIR=folder"; exit 2; }
	@$(CARGO) build -q --locked -p macros --example desk
	@python3 scripts/macros.py corpus target/debug/examples/desk "$(DIR)" out/macros

## make klipper-files DIR=folder  every printer.cfg in a folder migrated, and counted by another reader; needs Python
klipper-files: target/toolchain.mk
	@test -n "$(DIR)" || { echo "make klipper-files: say which folder with DIR=folder"; exit 2; }
	@$(CARGO) build -q --locked -p host
	@python3 scripts/klipper_files.py target/debug/velvet "$(DIR)" out/klipper-files

## make klippy KLIPPER=folder [ONLY="home print"] [PACE=0.25 | LOCK=1] [GCODE=f.gcode] [ELF=image | MODEL=1]
##                               Klipper's host program out of this folder, unmodified, against the image controller on the virtual board:
##                               a table in out/klippy; LOCK=1 has them on one clock, MODEL=1 needs no image
klippy: $(if $(KLIPPER),$(if $(MODEL),,virtual-prime $(if $(filter $(IMAGE),$(ELF)),firmware)))
	@test -n "$(KLIPPER)" || { echo "make klippy: say where Klipper's tree is with KLIPPER=folder"; exit 2; }
	@python3 peers/klippy/run.py "$(KLIPPER)" out/klippy \
	    $(if $(MODEL),--model,--console $(VPRIME) --elf "$(if $(filter $(IMAGE),$(ELF)),$(CONTROLLER),$(ELF))") \
	    $(if $(LOCK),--lock) $(if $(PACE),--pace $(PACE)) $(if $(GCODE),--print "$(GCODE)") $(if $(ONLY),--only $(ONLY))

test-lint: target/toolchain.mk
	@echo "== rules and lints"
	@$(CARGO) run -q --locked -p xtask -- deps
	@$(CARGO) run -q --locked -p xtask -- shape
	@$(CARGO) run -q --locked -p xtask -- docs
	@$(CARGO) run -q --locked -p xtask -- words
	@if $(CARGO) fmt --version >/dev/null 2>&1; then $(CARGO) fmt --all --check; else echo "rustfmt is not installed: skipped"; fi
	@if $(CARGO) clippy --version >/dev/null 2>&1; then \
	    $(CARGO) clippy -q --locked --all-targets -- -D warnings && \
	    if [ -z "$(FW_FLAGS)" ]; then $(CARGO) clippy -q --locked -p bsp-prime -p boot -p firmware -p controller --release --target $(TRIPLE) -- -D warnings; fi; \
	else echo "clippy is not installed: skipped"; fi

test-desk:
	@$(MAKE) test-lint
	@$(MAKE) test-web
	@$(MAKE) test-host

# The page in web/dist is committed, so firmware is built without npm: only who changes the page needs it.
test-web:
	@echo "== the page"
	@if ! command -v npm >/dev/null 2>&1; then echo "npm is not installed: the check of the page is left out"; \
	elif ! (cd web && test -x node_modules/.bin/esbuild || npm ci --silent --no-audit --no-fund --prefer-offline); then \
	    echo "npm cannot fetch the page's packages: the check of the page is left out"; \
	else cd web && npm run --silent check -- --quick; fi

# The first of the tests of `make page`, where there is a browser.
test-page: firmware emulator
	@echo "== the page on the image"
	@if ! command -v npm >/dev/null 2>&1 || ! command -v "$${CHROMIUM:-chromium}" >/dev/null 2>&1; then \
	    echo "npm or Chromium is not installed: the page in a browser is left out"; \
	elif ! (cd web && test -x node_modules/.bin/esbuild || npm ci --silent --no-audit --no-fund --prefer-offline); then \
	    echo "npm cannot fetch the page's packages: the page in a browser is left out"; \
	else test -x $(VPRIME) || $(MAKE) virtual-prime; node web/tests/board.mjs "$(VPRIME)" "$(IMAGE)" out/page --quick; fi

test-host: target/toolchain.mk
	@echo "== host crates and scenarios"
	@unset MAKEFLAGS MFLAGS; $(CARGO) test -q --locked --no-fail-fast --features program/docs

# What the later tests need, made while those of the desk run: fat LTO and the emulator's largest crate take one core
# each for a long time, and so does a test program that waits for its longest test. Cargo makes the virtual board itself
# with its tests, from the crates that these are made of: built for itself it is made of other ones.
test-builds: emulator
	@cd virtual-prime && CARGO_TARGET_DIR=target $(VP_CARGO) test -q --locked --release --ignore-rust-version --no-run
	@$(MAKE) firmware
	@$(FW_CARGO) test -q --locked -p on-target --release --target $(TRIPLE) $(FW_FLAGS) --no-run

test-image: firmware emulator
	@test -x $(VPRIME) || $(MAKE) virtual-prime
	@echo "== tests on target, on the virtual board"
	@FW_CARGO="$(FW_CARGO)" FW_FLAGS="$(FW_FLAGS)" scripts/test-on-target.sh
	@$(MAKE) budget

test-virtual: firmware emulator
	@echo "== the image on the virtual board"
	@cd virtual-prime && CARGO_TARGET_DIR=target VELVET_ELF="$(CURDIR)/$(IMAGE)" FW_CARGO="$(FW_CARGO)" FW_FLAGS="$(FW_FLAGS)" \
	    $(VP_CARGO) test -q --locked --release --ignore-rust-version

clean:
	@rm -rf target virtual-prime/target out
