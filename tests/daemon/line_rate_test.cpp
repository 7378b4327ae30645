// How much of a paced line is used while blocks wait to be sent, in made-up time: 98 % of it and more, for
// every kind of text link, with the reply latency of a good adapter. The figures in real time are `./run
// bench links`.

#include <gtest/gtest.h>

#include "tests/peers/line_run.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;
namespace {

constexpr double kLeastUse = 0.98;
constexpr int kBlocks = 3000;  // the opening and the end are a small part
constexpr double kFarTooShort = 0.0005;

/// Bytes that left, over those that the line carries from the first block to the last one sent.
double use(const std::string& link, double bits, double latency) {
  LineRun run;
  run.latency = latency;
  run.bits_per_byte = bits;
  double began = 0.0, ended = 0.0;
  run.watch = [&](const SendState& state, double now, CommandQueue&) {
    if (state.phase == Phase::kRun && began == 0.0) began = now;
    if (state.phase != Phase::kDone) ended = now;
  };
  const std::string program = short_blocks(kBlocks, kFarTooShort);
  const LineOutcome outcome = link == "grbl"     ? run_grbl(program, run)
                              : link == "reprap" ? run_reprap(program, run)
                                                 : run_drip(program, run);
  EXPECT_TRUE(outcome.report) << outcome.report.error().message;
  const double byte_time = bits / (link == "dnc" ? 9600 : 115200);
  return static_cast<double>(outcome.said.size()) * byte_time / (ended - began);
}

TEST(LineRate, Grbl) {
  EXPECT_GE(use("grbl", 10, 0.0), kLeastUse);
  EXPECT_GE(use("grbl", 10, 0.016), kLeastUse) << "a receive buffer of 1024 bytes hides the latency of 16 ms";
}

TEST(LineRate, RepRapWithAWindowOfFour) { EXPECT_GE(use("reprap", 10, 0.001), kLeastUse); }

TEST(LineRate, DripFeed) { EXPECT_GE(use("dnc", 11, 0.001), kLeastUse); }

}  // namespace
}  // namespace tiltfeed
