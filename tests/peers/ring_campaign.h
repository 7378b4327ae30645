#pragma once
// Runs a program over a ring controller on a line full of faults, in made-up time, with an operator who
// resumes what is held and starts again what was killed; judges what the machine executed.

#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>

#include "daemon/stream/stream.h"
#include "tests/judges/same_block.h"
#include "tests/peers/ring_wire.h"
#include "tests/shapes/wide_machine.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;

/// A program as the post writes it, and what it means.
struct CampaignProgram {
  explicit CampaignProgram(int feeds) {
    static int count = 0;
    path = "/tmp/tiltfeed_campaign_" + std::to_string(::getpid()) + "_" + std::to_string(++count) + ".nc";
    std::ostringstream text;
    text << "G21 G90 G94\nG0 X0 Y0 Z50 A0 C0\nM3 S8000\nG93\n";
    char line[120];
    for (int i = 0; i < feeds; ++i) {
      std::snprintf(line, sizeof line, "G1 X%.4f Y%.4f Z%.4f A%.4f C%.4f F%.2f\n", 40 * std::sin(i * 0.01),
                    40 * std::cos(i * 0.013), 10 + 5 * std::sin(i * 0.1), 20 * std::sin(i * 0.003), i * 0.05,
                    6000.0 + i % 7);
      text << line;
    }
    text << "G94\nM5\nM2\n";
    lines = text.str();
    std::ofstream(path) << lines;
    std::istringstream in(lines);
    blocks = *sim::read_program(in, path, 'A', 'C');
  }
  ~CampaignProgram() { std::filesystem::remove(path); }
  CampaignProgram(const CampaignProgram&) = delete;
  CampaignProgram& operator=(const CampaignProgram&) = delete;
  std::string path, lines;
  std::vector<sim::Block> blocks;
};

struct CampaignOutcome {
  std::uint64_t faults = 0, kills = 0, resets = 0;
  std::string wrong;  ///< empty: as it must be
};

/// One seeded run. With a rule `reset` the run must end in a fault, and nothing may be executed afterwards.
inline CampaignOutcome campaign_run(const CampaignProgram& program, sim::FaultScript script,
                                    std::uint64_t seed, SeededBug bug, bool kill) {
  std::mt19937_64 random(seed);
  script.seed = seed * 2 + 1;
  sim::ModbusOptions ring;
  ring.ring = 8 + random() % 57;
  ring.boot_id = static_cast<std::uint16_t>(1 + random() % 60000);
  std::vector<sim::Block> executed;
  RingWire wire(wide_machine(), script, ring, bug,
                [&](const sim::TraceRow& row) { executed.push_back(row.command); });
  CommandQueue operator_;
  Attachment record;
  SendState newest;
  StreamHooks hooks;
  hooks.commands = &operator_;
  hooks.reserve = [&](std::uint64_t next, std::uint64_t) -> Result<std::uint64_t> {
    return record.reserved = next + 15;
  };
  hooks.progress = [&](const SendState& state) {
    newest = state;
    if (state.session != 0 && state.boot != 0) record.session = state.session, record.boot = state.boot;
    record.accepted = std::max(record.accepted, state.acknowledged);
    if (state.phase == Phase::kHold || state.phase == Phase::kToolChange) operator_.push({Order::kResume});
    if (state.phase == Phase::kRun && random() % 64 == 0) operator_.push({Order::kHold});
    if (state.phase == Phase::kRun && random() % 64 == 0)
      operator_.push({Order::kFeedOverride, 50 + static_cast<int>(random() % 100)});
    return true;
  };
  const LinkSpec spec = *parse_link("modbus-rtu:/dev/null@115200/1");
  SendOptions options;
  options.session_id = static_cast<std::uint16_t>(1 + random() % 65535);
  CampaignOutcome outcome;
  if (kill) wire.die_at = 5 + random() % 120;
  std::string path = program.path;
  Result<SendReport> sent = send_over(path, spec, wire, wire, options, hooks);
  const auto lost = [&] { return !sent && newest.loss == Loss::kWire; };
  for (; lost() && outcome.kills < 50; ++outcome.kills) {
    if (kill) wire.die_at = wire.exchanges + 5 + random() % 120;
    if (record.session == 0) {  // nothing was begun
      sent = send_over(path, spec, wire, wire, options, hooks);
      continue;
    }
    if (bug == SeededBug::kResumeFromRecord || bug == SeededBug::kResumeAsNewRun) {
      outcome.wrong = "continued beside the controller's counters";
      const std::uint64_t from = bug == SeededBug::kResumeFromRecord ? record.reserved : record.accepted;
      if (from != executed.size()) return outcome;
      outcome.wrong.clear();
    }
    SendOptions again;
    again.attach = record;
    sent = send_over(path, spec, wire, wire, again, hooks);
    // The run may have ended, or not begun, when it was killed: then the controller has no such session.
    if (!sent && newest.loss == Loss::kForgotten &&
        (executed.size() == program.blocks.size() || executed.empty())) {
      if (executed.empty()) {
        sent = send_over(path, spec, wire, wire, options, hooks);
        continue;
      }
      sent = SendReport{};
      break;
    }
  }
  outcome.faults = wire.line.faults();
  outcome.resets = wire.resets;
  const std::size_t after = executed.size();
  if (!sent && wire.resets > 0) {
    if (bug == SeededBug::kBootIgnored) {
      wire.clear_alarm();
      options.session_id = static_cast<std::uint16_t>(options.session_id ^ 0x5555);
      static_cast<void>(send_over(path, spec, wire, wire, options, hooks));
    }
    for (int i = 0; i < 20; ++i) {
      std::string in;
      static_cast<void>(wire.exchange({}, std::chrono::seconds(1), in));
    }
    if (executed.size() > after + ring.ring || (bug == SeededBug::kBootIgnored && executed.size() > after))
      outcome.wrong = "blocks executed after a restart of the controller";
  } else if (!sent) {
    outcome.wrong = sent.error().message;
  } else if (executed.size() != program.blocks.size()) {
    outcome.wrong =
        std::to_string(executed.size()) + " blocks executed of " + std::to_string(program.blocks.size());
  }
  for (std::size_t i = 0; i < executed.size() && outcome.wrong.empty(); ++i)
    if (i >= program.blocks.size() || !same_block(executed[i], program.blocks[i]))
      outcome.wrong = "block " + std::to_string(i + 1) + " is another one";
  return outcome;
}

}  // namespace tiltfeed
