// The program `tiltfeed-sim`: a simulated machine on a wire, the parts by formula, and the proof from a
// trace.

#include <sys/signalfd.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <optional>
#include <random>

#include "config/command_line.h"
#include "config/job.h"
#include "config/job_inputs.h"
#include "config/output_file.h"
#include "config/standard_output.h"
#include "config/version.h"
#include "pathgen/mesh/stl.h"
#include "sim/collision/machine_view.h"
#include "sim/engagement/engagement_command.h"
#include "sim/motion/dry_run.h"
#include "sim/parts/parts.h"
#include "sim/path_check/path_check_command.h"
#include "sim/proof/prove_command.h"
#include "sim/report/verify_command.h"
#include "sim/wire/endpoint.h"

namespace {

using namespace tiltfeed;
using namespace tiltfeed::sim;

constexpr int kDone = 0, kFailed = 1, kWrongUse = 2;
constexpr std::size_t kTraceBufferBytes = 1 << 20;

struct ServeOptions {
  std::string pty, grbl_tcp, grbl_ws, reprap, drip, modbus_tcp, modbus_rtu, job, trace, faults, speed = "max";
  int baud = 0;
  GrblOptions grbl;
  RepRapOptions marlin;
  ModbusOptions modbus;
  bool once = false;
};

int report(const Error& error) {
  std::cerr << "tiltfeed-sim: " << error.message << "\n";
  return error.code == Code::kUsage ? kWrongUse : kFailed;
}

/// "max" is 0. Errors: kUsage.
Result<double> parse_speed(const std::string& text) {
  if (text == "max") return 0.0;
  double speed = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), speed);
  if (error != std::errc() || end != text.data() + text.size() || !(speed > 0.0 && speed <= 1e6))
    return fail(Code::kUsage, "--speed " + text + ": 'max', or a number above 0 (1 is real time)");
  return speed;
}

/// HOST:PORT. Errors: kUsage.
Result<std::pair<std::string, int>> parse_address(const std::string& text) {
  const std::size_t colon = text.rfind(':');
  int port = -1;
  if (colon != std::string::npos) {
    const char* const last = text.data() + text.size();
    const auto [end, error] = std::from_chars(text.data() + colon + 1, last, port);
    if (error == std::errc() && end == last && port >= 0 && port <= 65535)
      return std::pair(text.substr(0, colon) == "localhost" ? "127.0.0.1" : text.substr(0, colon), port);
  }
  return fail(Code::kUsage, "--modbus-tcp " + text + ": HOST:PORT, such as 127.0.0.1:1502");
}

/// A descriptor that becomes readable at SIGINT, SIGTERM or SIGHUP, which no longer end the process.
int catch_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&signals, signal);
  sigprocmask(SIG_BLOCK, &signals, nullptr);
  return signalfd(-1, &signals, SFD_CLOEXEC);
}

/// The trace file, written as blocks are executed; without a path it takes rows and keeps none.
class Trace {
 public:
  Result<void> open(const std::string& path) {
    if (path.empty()) return {};
    path_ = path;
    file_.rdbuf()->pubsetbuf(buffer_.data(), static_cast<std::streamsize>(buffer_.size()));
    file_.open(path, std::ios::binary | std::ios::trunc);
    write_trace_header(file_);
    return close_or_flush();
  }
  void take(const TraceRow& row) {
    if (path_.empty()) return;
    write_trace_row(row, file_);
    fresh_ = true;
  }
  void flush() {
    if (fresh_) file_.flush();
    fresh_ = false;
  }
  Result<void> close_or_flush() {
    if (!path_.empty() && !file_.flush()) return fail(Code::kIo, path_ + ": the trace cannot be written");
    return {};
  }

 private:
  std::string path_, buffer_ = std::string(kTraceBufferBytes, '\0');
  std::ofstream file_;
  bool fresh_ = false;
};

void summarise(const Motion& motion, ReferenceRun& reference, const char* lost_name, std::uint64_t lost) {
  const MotionTotals& totals = motion.totals();
  std::printf(
      "executed %llu blocks, machine time %.3f s, starved %.3f s, short of look-ahead %.3f s, %s %llu\n",
      static_cast<unsigned long long>(totals.blocks), totals.busy, totals.starved,
      std::max(0.0, totals.busy - reference.seconds()), lost_name, static_cast<unsigned long long>(lost));
}

int serve(const ServeOptions& options) {
  const int wires = !options.pty.empty() + !options.grbl_tcp.empty() + !options.grbl_ws.empty() +
                    !options.reprap.empty() + !options.drip.empty() + !options.modbus_tcp.empty() +
                    !options.modbus_rtu.empty();
  if (wires != 1 || options.job.empty())
    return report(
        {Code::kUsage,
         "one of --pty, --grbl-tcp, --grbl-ws, --reprap, --dnc, --modbus-tcp, --modbus-rtu and --job are "
         "needed; see --help"});
  EndpointOptions endpoint;
  const Result<double> speed = parse_speed(options.speed);
  if (!speed) return report(speed.error());
  endpoint.speed = *speed;
  endpoint.once = options.once;
  // 8N1 has ten bits a byte; 7E2 and the 8E1 of Modbus have eleven.
  const int bits = options.drip.empty() && options.modbus_rtu.empty() ? 10 : 11;
  if (options.baud > 0) endpoint.byte_time = static_cast<double>(bits) / options.baud;
  if (!options.faults.empty()) {
    const Result<FaultScript> script = load_fault_script(options.faults);
    if (!script) return report(script.error());
    endpoint.faults = *script;
  }

  const auto address = parse_address(options.modbus_tcp.empty() ? "127.0.0.1:0" : options.modbus_tcp);
  if (!address) return report(address.error());

  const auto jobs = config::load_operations(options.job, {});
  if (!jobs) return report(jobs.error());
  const config::Job* const job = &jobs->front();  // the machine is the same for all
  std::vector<config::NamedFile> inputs = config::files_of(*job);
  inputs.push_back({"--faults", options.faults});
  const auto fits = config::check_outputs({{"--trace", options.trace}}, inputs);
  if (!fits) return report(fits.error());
  Trace trace;
  if (const auto opened = trace.open(options.trace); !opened) return report(opened.error());
  endpoint.stop_fd = catch_signals();
  endpoint.flush = [&] { trace.flush(); };
  endpoint.ready = [](const std::string& where) {
    std::printf("ready on %s\n", where.c_str());
    std::fflush(stdout);
  };
  MotionOptions motion = motion_options(job->machine);
  // Whatever the profile says of the program's text: Grbl counts all axes, the ring X Y Z.
  const bool grbl_wire = !options.pty.empty() || !options.grbl_tcp.empty() || !options.grbl_ws.empty();
  motion.feed_over_all_axes = grbl_wire;
  motion.begins_on_top = true;
  ReferenceRun reference(job->machine.model, job->setup, motion);
  const auto sink = [&](const TraceRow& row) {
    trace.take(row);
    reference.take(row);
  };

  endpoint.line = [](std::size_t bytes, double use) {
    if (use > 0.0) std::printf("line carried %zu bytes, use %.2f %%\n", bytes, 100.0 * use);
  };
  Result<void> served;
  if (!options.reprap.empty()) {
    RepRapController controller(job->machine.model, job->setup, options.marlin, sink);
    served = serve_pty(controller, options.reprap, endpoint);
    summarise(controller.motion(), reference, "resends", controller.totals().resends);
  } else if (!options.drip.empty()) {
    DripController controller(job->machine.model, job->setup, {}, sink);
    served = serve_pty(controller, options.drip, endpoint);
    summarise(controller.motion(), reference, "alarm", static_cast<std::uint64_t>(controller.alarm()));
  } else if (grbl_wire) {
    GrblOptions grbl = options.grbl;
    grbl.motion = motion;
    GrblController controller(job->machine.model, job->setup, grbl, sink);
    served = !options.pty.empty()       ? serve_pty(controller, options.pty, endpoint)
             : !options.grbl_ws.empty() ? serve_ws(controller, options.grbl_ws, endpoint)
                                        : serve_tcp(controller, options.grbl_tcp, endpoint);
    summarise(controller.motion(), reference, "dropped bytes", controller.dropped_bytes());
  } else {
    ModbusOptions modbus = options.modbus;
    modbus.motion = motion;
    modbus.boot_id = static_cast<std::uint16_t>(std::random_device{}() | 1U);  // another at every start
    ModbusController controller(job->machine.model, job->setup, modbus, sink);
    if (!options.modbus_tcp.empty()) {
      served = serve_modbus_tcp(controller, address->first, address->second, endpoint);
    } else {
      served = serve_modbus_rtu(controller, options.modbus_rtu, endpoint);
    }
    summarise(controller.motion(), reference, "refused frames", controller.rejected_windows());
  }
  if (!served) return report(served.error());
  if (const auto closed = trace.close_or_flush(); !closed) return report(closed.error());
  return kDone;
}

int make_part(const std::string& name, const std::string& path) {
  if (const auto fits = config::check_outputs({{"--out", path}}, {}); !fits) return report(fits.error());
  const Result<Triangles> part = part_by_name(name);
  if (!part) return report(part.error());
  const auto bytes = pathgen::stl_bytes(path, *part);
  if (!bytes) return report(bytes.error());
  if (const auto written = config::write_file(path, *bytes); !written) return report(written.error());
  std::fprintf(path == "-" ? stderr : stdout, "%s: %zu facets\n", path.c_str(), part->size());
  return kDone;
}

void add_serve_options(CLI::App& app, ServeOptions& options) {
  app.add_option("--pty", options.pty, "serve Grbl on a pseudo-terminal; PATH becomes a link to it");
  app.add_option("--grbl-tcp", options.grbl_tcp,
                 "serve Grbl over TCP on ADDRESS:PORT; port 0 takes a free one");
  app.add_option("--grbl-ws", options.grbl_ws, "the same through a WebSocket");
  app.add_option("--reprap", options.reprap, "serve RepRap firmware (Marlin) on a pseudo-terminal");
  app.add_flag("--advanced-ok", options.marlin.advanced_ok,
               "RepRap: each ok says how many commands there is room for");
  app.add_option("--dnc", options.drip, "serve a CNC control's drip feed on a pseudo-terminal");
  app.add_option("--faults", options.faults, "what goes wrong on the wire: a fault script");
  app.add_option("--baud", options.baud, "serial links: pace the line, bits per second")
      ->check(CLI::Range(300, 4000000));
  app.add_option("--modbus-tcp", options.modbus_tcp,
                 "serve Modbus TCP on HOST:PORT; port 0 takes a free one");
  app.add_option("--modbus-rtu", options.modbus_rtu, "serve Modbus RTU, unit 1, on a pseudo-terminal");
  app.add_option("--job", options.job, "the job file: machine, set-up and tool");
  app.add_option("--trace", options.trace, "write what is executed to this CSV file");
  app.add_option("--speed", options.speed, "simulated seconds per real second, or max")
      ->capture_default_str();
  app.add_option("--rx-buffer", options.grbl.rx_buffer, "Grbl: receive buffer, bytes")
      ->capture_default_str()
      ->check(CLI::Range(16, 1 << 20));
  app.add_option("--planner", options.grbl.planner, "Grbl: planner, blocks")
      ->capture_default_str()
      ->check(CLI::Range(1, 100000));
  app.add_option("--probe-plate", options.grbl.plate, "Grbl: machine Z where a probe touches");
  app.add_option("--ring", options.modbus.ring, "Modbus: ring, blocks")
      ->capture_default_str()
      ->check(CLI::Range(1, 32767));
  app.add_flag("--once", options.once, "leave after the first program, when the host is gone or silent");
}

CLI::App* add_verify_options(CLI::App& app, VerifyOptions& options) {
  CLI::App* const verify =
      app.add_subcommand("verify", "cut the stock by a program or a trace and compare with the part");
  verify->add_option("JOB", options.job, "the job file")->required();
  verify->add_option("PROGRAM", options.program, "the program (G-code)");
  verify->add_option("--trace", options.trace, "what a machine executed, instead of a program");
  verify->add_option("--canon", options.canon, "what LinuxCNC's rs274 makes of a program, instead of it");
  verify->add_option("--stock", options.stock,
                     "offset:MM, box, box:MM, cylinder, cylinder:MM or an STL file; default: what the job's "
                     "rapids allow for");
  verify->add_option("--resolution", options.resolution, "distance of the stock's lines, mm");
  verify->add_option("--bundles", options.bundles, "of the stock's lines: 1, along the tool, or 3")
      ->check(CLI::IsMember({1, 3}))
      ->capture_default_str();
  verify->add_option(
      "--out", options.out,
      "folder for the report: index.html, report.json, pictures; or FILE.html, the page alone");
  verify->add_option("--stl", options.stl, "take this part instead of the job's");
  verify->add_option("--machine", options.machine, "take this machine profile instead of the job's");
  verify->add_option("--operation", options.operation,
                     "the program is that of this operation of the job alone");
  verify->add_option("--progress", options.progress)->group("");
  verify->add_flag("--json", options.as_json, "print the report (JSON) instead of its summary");
  verify->add_option("--threads", options.threads, "the result is the same for any number")
      ->check(CLI::Range(1, 256));
  return verify;
}

CLI::App* add_prove_options(CLI::App& app, ProveOptions& options) {
  CLI::App* const prove = app.add_subcommand(
      "prove",
      "hold every move of a program, in any dialect, against the job's part. Proven is that no "
      "tool, shank or holder cuts into the part, that bodies keep clear of each other, and what "
      "stands round the moves. Not proven are feeds, coolant, which tool is made ready next, whether a "
      "move cuts or is a rapid, lines that are missing where the tool stays clear, and what is left: verify "
      "sees these");
  prove->add_option("JOB", options.job, "the job file")->required();
  prove->add_option("PROGRAM", options.program, "the program, in the dialect of the job's machine")
      ->required();
  prove->add_option("--stl", options.stl, "take this part instead of the job's");
  prove->add_option("--machine", options.machine, "take this machine profile instead of the job's");
  prove->add_option("--operation", options.operation,
                    "the program is that of this operation of the job alone");
  prove->add_option("--name", options.name, "of the program in messages");
  prove->add_option("--picture", options.picture, "draw the deepest gouge to this PNG file");
  prove->add_flag("--closed", options.closed,
                  "a job of somebody else: no other file that it names is read than part and profile");
  prove->add_flag("--told", options.told, "the program is whole when a line comes on standard input")
      ->group("");
  prove->add_flag("--progress", options.progress, "lines of progress on standard output")->group("");
  prove->add_option("--threads", options.threads, "the result is the same for any number")
      ->check(CLI::Range(1, 256));
  return prove;
}

CLI::App* add_engagement_options(CLI::App& app, EngagementFiles& files) {
  CLI::App* const engagement = app.add_subcommand(
      "engagement",
      "what the cutter has to cut along a program: volume, engaged angle and depth, chip and load");
  engagement->add_option("JOB", files.job, "the job file")->required();
  engagement->add_option("PROGRAM", files.program, "the program, in the dialect of the job's machine")
      ->required();
  engagement->add_option("--out", files.table, "table to write (CSV): a row for each short span at feed");
  engagement->add_option("--plot", files.plot,
                         "picture to write (SVG): feed, load, angle and removal over time");
  engagement->add_option("--before", files.before,
                         "such a table of another program of the job, drawn behind in grey");
  engagement->add_option(
      "--stock", files.stock,
      "offset:MM, box, box:MM, cylinder, cylinder:MM or an STL file; default: what the job's "
      "rapids allow for");
  engagement->add_option("--resolution", files.resolution, "distance of the stock's lines, mm");
  engagement->add_option("--stl", files.stl, "take this part instead of the job's");
  engagement->add_option("--machine", files.machine, "take this machine profile instead of the job's");
  engagement->add_option("--operation", files.operation,
                         "the program is that of this operation of the job alone");
  engagement->add_flag("--progress", files.progress, "lines of progress on standard output")->group("");
  engagement->add_option("--threads", files.threads, "the result is the same for any number")
      ->check(CLI::Range(1, 256));
  return engagement;
}

/// The exit status.
int run(int argc, char** argv) {
  CLI::App app("A simulated five-axis machine (table C, tilting head), seen through its wire.",
               "tiltfeed-sim");
  app.set_version_flag("--version", "tiltfeed-sim " + config::version());
  ServeOptions options;
  add_serve_options(app, options);

  std::string name, out;
  CLI::App* const part = app.add_subcommand("part", "write one of the parts that are made by formula as STL");
  part->add_option("NAME", name, "tyre, pin, sphere or handle")->required();
  part->add_option("--out", out, "the STL file")->required();

  PathCheckFiles files;
  CLI::App* const check = app.add_subcommand(
      "check-path", "prove from an executed trace, or a program, that a job was done right");
  check->add_option("JOB", files.job, "the job file")->required();
  check->add_option("--program", files.program, "the program that was sent");
  check->add_option("--canon", files.canon, "instead: what rs274 of LinuxCNC made of it");
  check->add_option("--cl", files.cl, "the planned tool path")->required();
  check->add_option("--trace", files.trace,
                    "what the machine executed; without it the program is executed here");
  check->add_option("--picture", files.picture, "draw part and path to this PNG file");
  check->add_option("--report", files.report,
                    "the planner's report: what it could not reach is marked there");
  check->add_option("--out", files.json, "write the report (JSON) to this file");
  std::string old_json;  // elsewhere --json is no file
  check->add_option("--json", old_json)->group("");

  MachineViewOptions seen;
  CLI::App* const machine = app.add_subcommand(
      "machine", "write what draws the machine and fixtures of a job: links, axes, solids");
  machine->add_option("JOB", seen.job, "the job file")->required();
  machine->add_option("--machine", seen.machine, "take this machine profile instead of the job's");
  machine->add_option("--out", seen.out, "the file, as sim/collision/README.md says")->required();

  VerifyOptions verification;
  CLI::App* const verify = add_verify_options(app, verification);
  ProveOptions proof;
  CLI::App* const prove = add_prove_options(app, proof);
  EngagementFiles engaged;
  CLI::App* const engagement = add_engagement_options(app, engaged);
  app.require_subcommand(0, 1);

  if (argc == 2 && std::string_view(argv[1]) == config::kDescribeWord) {
    std::cout << config::command_json(config::describe_command_line(app, "tiltfeed-sim")) << "\n";
    return kDone;
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return config::report_parse_end(app, error) ? kDone : kWrongUse;
  }
  if (part->parsed()) return make_part(name, out);
  if (check->parsed()) {
    if (!old_json.empty()) {
      std::cerr
          << "tiltfeed-sim: check-path --json FILE is --out FILE now; the next version does not know it\n";
      files.json = old_json;
    }
    const Result<bool> passed = path_check_command(files);
    if (!passed) return report(passed.error());
    return *passed ? kDone : kFailed;
  }
  if (machine->parsed()) {
    const Result<void> written = machine_view_command(seen);
    return written ? kDone : report(written.error());
  }
  if (prove->parsed()) return prove_command(proof);
  if (engagement->parsed()) return engagement_command(engaged);
  if (verify->parsed()) return verify_command(verification);
  return serve(options);
}

}  // namespace

int main(int argc, char** argv) {
  tiltfeed::config::open_standard_streams();
  return tiltfeed::config::close_standard_output("tiltfeed-sim", run(argc, argv));
}
