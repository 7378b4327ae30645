// The program `tiltfeed`: its command line, and the way from STL to program text in order.

#include <sys/resource.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <iostream>
#include <optional>

#include "config/job_files.h"
#include "daemon/block.h"
#include "daemon/block_map.h"
#include "daemon/interrupt.h"
#include "daemon/machine_command.h"
#include "daemon/near_pole.h"
#include "daemon/output_file.h"
#include "daemon/plan_report.h"
#include "daemon/post_command.h"
#include "daemon/service_command.h"
#include "daemon/space_about.h"
#include "daemon/stream.h"
#include "daemon/tool_length.h"
#include "daemon/verify_command.h"
#include "kinematics/cl_file.h"
#include "kinematics/joint_path.h"
#include "kinematics/tcp_path.h"
#include "pathgen/mesh.h"
#include "pathgen/plan.h"
#include "pathgen/stl.h"

namespace {

using namespace tiltfeed;

constexpr int kDone = 0, kFailed = 1, kWrongUse = 2;
/// The post's share of the job's tolerance; pathgen uses half, the rest is rounding.
constexpr double kPostShare = 0.35;

int report(const Error& error) {
  std::cerr << "tiltfeed: " << error.message << "\n";
  return error.code == Code::kUsage ? kWrongUse : kFailed;
}

/// Stage lines on standard error: rewritten in place on a terminal; elsewhere one a stage.
class ProgressLine {
 public:
  bool show(const std::string& text, double fraction) {
    const auto now = std::chrono::steady_clock::now();
    const bool fresh = text != text_;
    if (fresh || (terminal_ && now - shown_ > kRedraw)) {
      if (terminal_)
        std::fprintf(stderr, "\r\033[K%s %3.0f %%", text.c_str(), fraction * 100.0);
      else
        std::fprintf(stderr, "%s\n", text.c_str());
      text_ = text;
      shown_ = now;
    }
    return !interrupted();
  }
  ~ProgressLine() {
    if (terminal_ && !text_.empty()) std::fprintf(stderr, "\r\033[K");
  }

 private:
  static constexpr std::chrono::milliseconds kRedraw{100};
  const bool terminal_ = isatty(STDERR_FILENO) == 1;
  std::string text_;
  std::chrono::steady_clock::time_point shown_;
};

/// Wall time of the stages that main itself runs.
class StageClock {
 public:
  template <class Function>
  auto time(const char* stage, Function function) {
    const auto start = std::chrono::steady_clock::now();
    auto result = function();
    times.push_back({stage, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count()});
    return result;
  }
  std::vector<StageTime> times;
};

Result<void> write_text(const std::string& path, const std::function<Result<void>(std::ostream&)>& write) {
  auto file = OutputFile::open(path);
  if (!file) return tl::unexpected(file.error());
  if (auto written = write(file->stream()); !written) return written;
  return file->commit();
}

struct PlanFiles {
  std::string job, program, cl, report, map, stl, machine;
};

int plan_command(const PlanFiles& files) {
  auto job = load_job_with(files.job, {files.stl, files.machine});
  if (!job) return report(job.error());
  ProgressLine line;
  StageClock clock;
  line.show("read", 0.0);
  auto stl = clock.time("read", [&] { return read_stl(job->stl_path, job->stl_unit_mm); });
  if (!stl) return report(stl.error());
  line.show("check", 0.0);
  auto part = clock.time("check", [&] { return check_mesh(*stl, {job->plan.tolerance * kRepairShare}); });
  if (!part) return report(part.error());
  *stl = Stl{};  // gives its memory back; facets = {} would keep it
  job->plan.find_uncut = !files.report.empty();
  auto planned = plan(*part, job->plan, [&](const char* stage, double f) { return line.show(stage, f); });
  if (!planned) return report(planned.error());
  clock.times.insert(clock.times.end(), planned->report.times.begin(), planned->report.times.end());

  const PoleBendReport bend = clock.time("pole", [&] { return bend_near_pole(*job, *part, planned->path); });

  if (!line.show("joints", 0.0)) return report({Code::kCancelled, "cancelled; nothing was written"});
  JointPathOptions options;
  options.tolerance = job->plan.tolerance * kPostShare;
  // What the axis may lean moves the shank's end by no more than the tip may stray.
  const Angle lean = Angle::from_radians(options.tolerance / job->plan.cutter.shank_length);
  options.axis_tolerance = std::min(options.axis_tolerance, lean.degrees());
  // Under TCP the linear words are the tip's, so joints are kept finer than what is printed.
  options.linear_decimals = job->machine.format.tcp ? kTcpDecimals : job->machine.format.linear_decimals;
  options.rotary_decimals = job->machine.format.rotary_decimals;
  options.clear = space_about(part->mesh, *job);
  auto joints = clock.time("joints", [&] {
    return to_joints(planned->path, job->machine.model, job->setup, options,
                     [&](double f) { return line.show("joints", f); });
  });
  if (!joints) return report(joints.error());
  if (joints->reconfigured) planned->path = std::move(*joints->reconfigured);
  const Timing timing = clock.time("timing", [&] {
    return time_blocks(joints->moves, job->machine.model, options.tolerance, options.axis_tolerance);
  });

  if (!line.show("write", 0.0)) return report({Code::kCancelled, "cancelled; nothing was written"});
  ProgramReport program;
  auto written = clock.time("write", [&] {
    return write_text(files.program, [&](std::ostream& out) -> Result<void> {
      auto blocks = write_program(*joints, *job, out, [&](double f) { return line.show("write", f); });
      if (!blocks) return tl::unexpected(blocks.error());
      program = *blocks;
      return {};
    });
  });
  if (!written) return report(written.error());
  if (!files.cl.empty()) {
    auto cl = clock.time("cl file", [&] {
      return write_text(files.cl, [&](std::ostream& out) -> Result<void> {
        return write_cl(planned->path, out), Result<void>{};
      });
    });
    if (!cl) return report(cl.error());
  }
  if (!files.map.empty()) {
    auto map = write_text(files.map, [&](std::ostream& out) -> Result<void> {
      return write_block_map(*joints, planned->path, out), Result<void>{};
    });
    if (!map) return report(map.error());
  }
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](timeval t) {
    return static_cast<double>(t.tv_sec) + static_cast<double>(t.tv_usec) * 1e-6;
  };
  const PlanOutcome outcome{*job,
                            *part,
                            planned->report,
                            bend,
                            joints->report,
                            program,
                            timing,
                            starved(timing, job->machine, program),
                            clock.times,
                            seconds(usage.ru_utime) + seconds(usage.ru_stime),
                            static_cast<double>(usage.ru_maxrss) / 1024.0};
  if (!files.report.empty()) {
    auto text = write_text(files.report, [&](std::ostream& out) -> Result<void> {
      return out << report_json(outcome), Result<void>{};
    });
    if (!text) return report(text.error());
  }
  line.show("done", 1.0);
  std::cout << report_text(outcome);
  return kDone;
}

int check_command(const std::string& path) {
  auto job = load_job(path);
  if (!job) return report(job.error());
  std::cout << describe(*job);
  return kDone;
}

int send_command(const std::string& program, std::string link_text, const std::string& machine) {
  MachineProfile profile;
  if (!machine.empty()) {
    auto loaded = load_machine(machine);
    if (!loaded) return report(loaded.error());
    profile = std::move(*loaded);
  }
  if (link_text.empty()) link_text = profile.link;
  if (link_text.empty())
    return report({Code::kUsage, "no link: give --link, or --machine with a profile that has link.default"});
  const auto link = parse_link(link_text, profile.wire);
  if (!link) return report(link.error());
  ProgressLine line;
  auto sent = send_program(program, *link, {}, {[&](const SendState& state) {
                             return line.show(std::string("send: ") + phase_name(state.phase),
                                              state.total > 0 ? static_cast<double>(state.acknowledged) /
                                                                    static_cast<double>(state.total)
                                                              : 0.0);
                           }});
  if (!sent) return report(sent.error());
  std::printf("%llu blocks %s in %.2f s, %llu bytes, %llu resends\n",
              static_cast<unsigned long long>(sent->lines), sent->executed ? "sent and executed" : "sent",
              sent->seconds, static_cast<unsigned long long>(sent->bytes),
              static_cast<unsigned long long>(sent->resends));
  return kDone;
}

}  // namespace

int main(int argc, char** argv) {
  hear_interrupts();
  CLI::App app{
      "Tiltfeed: from an STL part to a 5-axis machine with a rotary table and a tilting head.\n"
      "Not a safety device: emergency stop and guards belong to the machine."};
  app.set_version_flag("--version", "tiltfeed " TILTFEED_VERSION);
  app.require_subcommand(1);

  std::string check_job;
  CLI::App* check = app.add_subcommand("check", "read a job and its machine profile, print them resolved");
  check->add_option("JOB", check_job, "job file (YAML)")->required();

  // Its options are those of `tiltfeed-sim simulate`, which takes them as they are.
  CLI::App* verify =
      app.add_subcommand("verify", "cut the stock by a program or a trace and compare with the part");
  verify->prefix_command()->set_help_flag();

  PlanFiles files;
  CLI::App* planning = app.add_subcommand("plan", "plan the tool path and write the machine's program");
  planning->add_option("JOB", files.job, "job file (YAML)")->required();
  planning->add_option("--out", files.program, "program to write (G-code)")->required();
  planning->add_option("--cl", files.cl, "cutter location file to write (APT text)");
  planning->add_option("--report", files.report, "report to write (JSON)");
  planning->add_option("--map", files.map, "map to write: from each motion block to its move and STL facet");
  planning->add_option("--stl", files.stl, "take this part instead of the job's");
  planning->add_option("--machine", files.machine, "take this machine profile instead of the job's");

  std::string program, link, send_machine;
  CLI::App* send = app.add_subcommand("send", "stream a program to the controller");
  send->add_option("PROGRAM", program, "program to send (G-code)")->required();
  send->add_option(
      "--link", link,
      "grbl:/dev/ttyUSB0@115200, reprap:/dev/ttyACM0@250000, dnc:/dev/ttyS0@9600, "
      "modbus-tcp:HOST:PORT, modbus-rtu:/dev/ttyS0@19200, drive-tcp:HOST:PORT, drive-rtu:/dev/ttyS0@19200; "
      "else the profile's link.default");
  send->add_option("--machine", send_machine, "machine profile (YAML): its default link and its wire");

  double tool_length = 0.0;
  send->add_option("--tool-length", tool_length,
                   "gauge line to tip of the tool in the spindle, mm; a program for another is refused")
      ->check(CLI::PositiveNumber);

  const PostCommands posting(app);
  const MachineCommands machines(app);
  ServiceCommands service(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kDone : kWrongUse;
  }
  if (verify->parsed()) return report(run_verify(verify->remaining()));
  if (const std::optional<int> status = service.run()) return *status;
  if (send->parsed()) {
    if (send->count("--tool-length") > 0)
      if (auto same = check_tool_length(program, tool_length); !same) return report(same.error());
    return send_command(program, link, send_machine);
  }
  const PromptEnd prompt_end;  // what touches no machine may end at any place
  if (check->parsed()) return check_command(check_job);
  if (planning->parsed()) return plan_command(files);
  return posting.called() ? posting.run() : machines.run();
}
