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

#include "config/job.h"
#include "kinematics/cl_file.h"
#include "pathgen/mesh.h"
#include "pathgen/stl.h"
#include "sim/endpoint.h"
#include "sim/parts.h"
#include "sim/picture.h"
#include "sim/simulate_command.h"
#include "sim/verify.h"

namespace {

using namespace tiltfeed;
using namespace tiltfeed::sim;

constexpr int kDone = 0, kFailed = 1, kWrongUse = 2;
constexpr std::size_t kTraceBufferBytes = 1 << 20;

struct ServeOptions {
  std::string pty, modbus_tcp, modbus_rtu, job, trace, speed = "max";
  GrblOptions grbl;
  ModbusOptions modbus;
  bool once = false;
};

struct VerifyFiles {
  std::string job, program, cl, trace, picture, json;
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

void summarise(const Motion& motion, const char* lost_name, std::uint64_t lost) {
  const MotionTotals& totals = motion.totals();
  std::printf("executed %llu blocks, machine time %.3f s, starved %.3f s, %s %llu\n",
              static_cast<unsigned long long>(totals.blocks), totals.busy, totals.starved, lost_name,
              static_cast<unsigned long long>(lost));
}

int serve(const ServeOptions& options) {
  const int wires = !options.pty.empty() + !options.modbus_tcp.empty() + !options.modbus_rtu.empty();
  if (wires != 1 || options.job.empty())
    return report(
        {Code::kUsage, "one of --pty, --modbus-tcp, --modbus-rtu and --job are needed; see --help"});
  EndpointOptions endpoint;
  const Result<double> speed = parse_speed(options.speed);
  if (!speed) return report(speed.error());
  endpoint.speed = *speed;
  endpoint.once = options.once;

  const auto address = parse_address(options.modbus_tcp.empty() ? "127.0.0.1:0" : options.modbus_tcp);
  if (!address) return report(address.error());

  const Result<Job> job = load_job(options.job);
  if (!job) return report(job.error());
  Trace trace;
  if (const auto opened = trace.open(options.trace); !opened) return report(opened.error());
  endpoint.stop_fd = catch_signals();
  endpoint.flush = [&] { trace.flush(); };
  endpoint.ready = [](const std::string& where) {
    std::printf("ready on %s\n", where.c_str());
    std::fflush(stdout);
  };
  const auto sink = [&](const TraceRow& row) { trace.take(row); };

  Result<void> served;
  if (!options.pty.empty()) {
    GrblOptions grbl = options.grbl;
    grbl.motion = motion_options(job->machine);
    grbl.motion.feed_over_all_axes = true;  // whatever the profile says of the program's text
    GrblController controller(job->machine.model, job->setup, grbl, sink);
    served = serve_pty(controller, options.pty, endpoint);
    summarise(controller.motion(), "dropped bytes", controller.dropped_bytes());
  } else {
    ModbusOptions modbus = options.modbus;
    modbus.motion = motion_options(job->machine);
    modbus.boot_id = static_cast<std::uint16_t>(std::random_device{}() | 1U);  // another at every start
    ModbusController controller(job->machine.model, job->setup, modbus, sink);
    if (!options.modbus_tcp.empty()) {
      served = serve_modbus_tcp(controller, address->first, address->second, endpoint);
    } else {
      served = serve_modbus_rtu(controller, options.modbus_rtu, endpoint);
    }
    summarise(controller.motion(), "refused frames", controller.rejected_windows());
  }
  if (!served) return report(served.error());
  if (const auto closed = trace.close_or_flush(); !closed) return report(closed.error());
  return kDone;
}

int make_part(const std::string& name, const std::string& path) {
  const Result<Triangles> part = part_by_name(name);
  if (!part) return report(part.error());
  if (const auto written = write_stl(path, *part); !written) return report(written.error());
  std::printf("%s: %zu facets\n", path.c_str(), part->size());
  return kDone;
}

/// Opens `path` and reads it with `read(stream, path)`.
template <class Read>
auto read_file(const std::string& path, const Read& read)
    -> decltype(read(std::declval<std::istream&>(), path)) {
  std::ifstream in(path, std::ios::binary);
  if (!in) return fail(Code::kIo, path + ": cannot be opened");
  return read(in, path);
}

void print(const VerifyReport& r) {
  const auto line = [](const char* what, const Extreme& worst, const char* unit) {
    std::printf("  %-16s %.6f %s (block %llu, line %u)\n", what, worst.value, unit,
                static_cast<unsigned long long>(worst.place.block), worst.place.line);
  };
  std::printf("%s\n", r.passed() ? "passed" : "FAILED");
  std::printf(
      "  blocks           %llu of %llu executed, %llu missing, %llu repeated, %llu altered\n",
      static_cast<unsigned long long>(r.program.executed), static_cast<unsigned long long>(r.program.blocks),
      static_cast<unsigned long long>(r.program.missing), static_cast<unsigned long long>(r.program.repeated),
      static_cast<unsigned long long>(r.program.altered));
  line("gouge", r.gouge, "mm");
  line("rapid overlap", r.rapid_overlap, "mm");
  line("gap", r.gap, "mm");
  line("tip deviation", r.tip_deviation, "mm");
  line("axis deviation", r.axis_deviation, "degrees");
  std::printf("  machine time     %.3f s\n", r.seconds);
  for (const std::string& failure : r.failures) std::printf("  %s\n", failure.c_str());
}

int verify_job(const VerifyFiles& files) {
  const Result<Job> job = load_job(files.job);
  if (!job) return report(job.error());
  const Result<Stl> stl = read_stl(job->stl_path, job->stl_unit_mm);
  if (!stl) return report(stl.error());
  const Result<CheckedMesh> part = check_mesh(*stl, {job->plan.tolerance * kRepairShare});
  if (!part) return report(part.error());
  const MachineModel& machine = job->machine.model;
  const auto program = read_file(files.program, [&](std::istream& in, const std::string& name) {
    return read_program(in, name, sim::GcodeReader(machine));
  });
  if (!program) return report(program.error());
  const auto planned = read_file(files.cl, read_cl);
  if (!planned) return report(planned.error());
  const auto trace = read_file(files.trace, read_trace);
  if (!trace) return report(trace.error());

  const auto verified =
      verify(*job, part->mesh, *program, *planned, *trace, {}, [](const char*, double) { return true; });
  if (!verified) return report(verified.error());
  print(*verified);
  if (!files.json.empty()) {
    std::ofstream out(files.json, std::ios::binary | std::ios::trunc);
    if (!(out << to_json(*verified) << std::flush))
      return report({Code::kIo, files.json + ": cannot be written"});
  }
  if (!files.picture.empty())
    if (const auto drawn = draw_part_with_path(part->mesh, *planned, files.picture); !drawn)
      return report(drawn.error());
  return verified->passed() ? kDone : kFailed;
}

void add_serve_options(CLI::App& app, ServeOptions& options) {
  app.add_option("--pty", options.pty, "serve Grbl on a pseudo-terminal; PATH becomes a link to it");
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
  app.add_option("--ring", options.modbus.ring, "Modbus: ring, blocks")
      ->capture_default_str()
      ->check(CLI::Range(1, 32767));
  app.add_flag("--once", options.once, "leave after the first program, when the host is gone or silent");
}

CLI::App* add_simulate_options(CLI::App& app, SimulateOptions& options) {
  CLI::App* const simulate =
      app.add_subcommand("simulate", "cut the stock by a program or a trace and compare with the part");
  simulate->add_option("JOB", options.job, "the job file")->required();
  simulate->add_option("PROGRAM", options.program, "the program (G-code)");
  simulate->add_option("--trace", options.trace, "what a machine executed, instead of a program");
  simulate->add_option(
      "--stock", options.stock,
      "offset:MM, box, box:MM, cylinder, cylinder:MM or an STL file; default: what the job's "
      "rapids allow for");
  simulate->add_option("--resolution", options.resolution, "distance of the stock's lines, mm");
  simulate->add_option("--bundles", options.bundles, "of the stock's lines: 1, along the tool, or 3")
      ->check(CLI::IsMember({1, 3}))
      ->capture_default_str();
  simulate->add_option("--out", options.out, "folder for the report: index.html, report.json, pictures");
  simulate->add_option("--threads", options.threads, "the result is the same for any number")
      ->check(CLI::Range(1, 256));
  return simulate;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("A simulated five-axis machine (table C, tilting head), seen through its wire.",
               "tiltfeed-sim");
  app.set_version_flag("--version", "tiltfeed-sim " TILTFEED_VERSION);
  ServeOptions options;
  add_serve_options(app, options);

  std::string name, out;
  CLI::App* const part = app.add_subcommand("part", "write one of the parts that are made by formula as STL");
  part->add_option("NAME", name, "tyre, pin, sphere or handle")->required();
  part->add_option("--out", out, "the STL file")->required();

  VerifyFiles files;
  CLI::App* const check =
      app.add_subcommand("verify", "prove from an executed trace that a job was done right");
  check->add_option("JOB", files.job, "the job file")->required();
  check->add_option("--program", files.program, "the program that was sent")->required();
  check->add_option("--cl", files.cl, "the planned tool path")->required();
  check->add_option("--trace", files.trace, "what the machine executed")->required();
  check->add_option("--picture", files.picture, "draw part and path to this PNG file");
  check->add_option("--json", files.json, "write the report to this file");

  SimulateOptions simulation;
  CLI::App* const simulate = add_simulate_options(app, simulation);
  app.require_subcommand(0, 1);

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kDone : kWrongUse;
  }
  if (part->parsed()) return make_part(name, out);
  if (check->parsed()) return verify_job(files);
  if (simulate->parsed()) return simulate_command(simulation);
  return serve(options);
}
