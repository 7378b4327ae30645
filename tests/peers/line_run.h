#pragma once
// Sends a program over a virtual serial line to a simulated controller and keeps what happened.

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <sstream>

#include "daemon/stream/stream.h"
#include "tests/peers/virtual_line.h"
#include "tests/shapes/wide_machine.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;

struct LineRun {
  std::string link = "grbl:/dev/null@115200";
  std::string faults;  ///< fault script
  LinkProfile profile = {};
  SendOptions options = {};
  double bits_per_byte = 10, latency = 0.0;
  /// Called with each progress and the time, s; may push orders.
  std::function<void(const SendState&, double, CommandQueue&)> watch = {};
};

struct LineOutcome {
  Result<SendReport> report;
  SendState last;
  std::vector<sim::Block> executed, program;
  std::string said;
  double seconds = 0.0, starved = 0.0;
  std::uint64_t faults = 0;
  bool whole() const { return report && executed.size() == program.size() && in_order(); }
  /// What was executed is the program's begin, block by block.
  bool in_order() const {
    for (std::size_t i = 0; i < executed.size(); ++i) {
      const sim::Block &a = executed[i], &b = program.at(std::min(i, program.size() - 1));
      if (i >= program.size() || a.op != b.op || a.m_code != b.m_code) return false;
      const Joints &p = a.target, &q = b.target;
      if (a.op == sim::Op::kFeed &&
          (p.x != q.x || p.y != q.y || p.z != q.z || p.a != q.a || p.c != q.c || a.feed != b.feed))
        return false;
    }
    return true;
  }
};

/// `feeds` G93 blocks of `each` seconds, as the post writes them.
inline std::string short_blocks(int feeds, double each) {
  std::string text = "G21 G90 G94\nG0 X0 Y0 Z50 A0 C0\nM3 S8000\nG93\n";
  char line[120];
  for (int i = 0; i < feeds; ++i) {
    std::snprintf(line, sizeof line, "G1X%.4fY%.4fZ%.4fA%.4fC%.4fF%.3f\n", 1 + i * 0.01, 2 + i * 0.02,
                  30 - i * 0.001, i * 0.001, i * 0.05, 60.0 / each);
    text += line;
  }
  return text + "G94\nM5\nM2\n";
}

template <class Controller, class Options>
LineOutcome run_line(const std::string& program, const Options& firmware, const LineRun& run) {
  static int count = 0;
  const std::string path =
      "/tmp/tiltfeed_line_" + std::to_string(::getpid()) + "_" + std::to_string(++count) + ".nc";
  std::ofstream(path) << program;
  const auto script = sim::parse_fault_script(run.faults, "faults");
  EXPECT_TRUE(script) << script.error().message;
  LineOutcome outcome;
  std::istringstream in(program);
  if (auto blocks = sim::read_program(in, path, 'A', 'C')) outcome.program = std::move(*blocks);
  Controller controller(wide_machine(), {}, firmware,
                        [&](const sim::TraceRow& row) { outcome.executed.push_back(row.command); });
  LinkSpec spec = *parse_link(run.link);
  spec.profile = run.profile;
  VirtualLine<Controller> line(controller, *script, run.bits_per_byte / spec.baud);
  line.latency = run.latency;
  CommandQueue queue;
  StreamHooks hooks;
  hooks.commands = &queue;
  hooks.progress = [&](const SendState& state) {
    outcome.last = state;
    if (run.watch) run.watch(state, line.time, queue);
    return line.time < 5000.0;
  };
  outcome.report = send_over(path, spec, line, line, run.options, hooks);
  outcome.seconds = line.time;
  std::string rest;
  for (int i = 0; i < 10; ++i) static_cast<void>(line.exchange({}, std::chrono::seconds(1), rest));
  // The barrier that ends a Grbl run is a dwell of no length.
  if (!outcome.executed.empty() && outcome.executed.back().op == sim::Op::kDwell &&
      outcome.executed.back().feed == 0.0)
    outcome.executed.pop_back();
  outcome.said = line.said;
  outcome.starved = controller.motion().totals().starved;
  outcome.faults = line.line.faults();
  std::filesystem::remove(path);
  return outcome;
}

inline LineOutcome run_grbl(const std::string& program, const LineRun& run, sim::GrblOptions firmware = {}) {
  return run_line<sim::GrblController>(program, firmware, run);
}
inline LineOutcome run_reprap(const std::string& program, LineRun run, sim::RepRapOptions firmware = {}) {
  run.link = "reprap:/dev/null@115200";
  return run_line<sim::RepRapController>(program, firmware, run);
}
inline LineOutcome run_drip(const std::string& program, LineRun run, sim::DripControlOptions control = {}) {
  run.link = "dnc:/dev/null@9600";
  run.bits_per_byte = 11;
  return run_line<sim::DripController>(program, control, run);
}

}  // namespace tiltfeed
