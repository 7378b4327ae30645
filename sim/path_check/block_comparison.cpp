#include "sim/path_check/block_comparison.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace tiltfeed::sim {
namespace {

// The trace prints axis words and feeds with 6 decimals, two more than any control; a changed word differs
// by at least 1e-5.
constexpr double kWordTolerance = 2e-6;
// A link that loses or repeats more blocks than this in one go is reported as altered blocks from there on.
constexpr std::size_t kResyncBlocks = 4096;

bool near(double a, double b) { return std::abs(a - b) <= kWordTolerance; }

bool same(const Block& a, const Block& b) {
  if (a.op != b.op) return false;
  if (a.op == Op::kMCode) return a.m_code == b.m_code;
  if (a.op == Op::kFeed && a.inverse_time != b.inverse_time) return false;
  if (a.op != Op::kRapid && !near(a.feed, b.feed)) return false;
  if (!a.placed) return true;  // from wherever the machine stood
  const Joints &p = a.target, &q = b.target;
  return near(p.x, q.x) && near(p.y, q.y) && near(p.z, q.z) && near(p.a, q.a) && near(p.c, q.c);
}

std::string number(double value) {
  char text[64];
  return {text, std::to_chars(text, text + sizeof text, value, std::chars_format::fixed, 4).ptr};
}

std::string text_of(const Block& block) {
  if (block.op == Op::kMCode) return "M" + std::to_string(block.m_code);
  const Joints& q = block.target;
  const char* code = block.op == Op::kRapid   ? "G0"
                     : block.op == Op::kDwell ? "G4"
                     : block.inverse_time     ? "G93 G1"
                                              : "G94 G1";
  return std::string(code) + " X" + number(q.x) + " Y" + number(q.y) + " Z" + number(q.z) + " A" +
         number(q.a) + " C" + number(q.c) + (block.op == Op::kRapid ? "" : " F" + number(block.feed));
}

/// `G4 P0`: a host ends a program with it, since its acknowledgement proves that all before it is executed.
bool is_barrier(const Block& block) { return block.op == Op::kDwell && block.feed == 0.0; }

/// Smallest k in 1..limit for which `agrees(k)`, or 0.
template <class Agrees>
std::size_t first_agreement(std::size_t limit, const Agrees& agrees) {
  for (std::size_t k = 1; k <= limit; ++k)
    if (agrees(k)) return k;
  return 0;
}

}  // namespace

BlockComparison compare_blocks(const std::vector<Block>& program, const std::vector<TraceRow>& trace) {
  BlockComparison check;
  check.blocks = program.size(), check.executed = trace.size();
  const auto note = [&](std::size_t i, std::size_t j, const std::string& what) {
    if (!check.first_difference.empty()) return;
    check.first_difference = "block " + std::to_string(i + 1) + " of the program" +
                             (i < program.size() ? " (" + text_of(program[i]) + ")" : " (its end)") + ": " +
                             what + ", row " + std::to_string(j + 1) + " of the trace is " +
                             (j < trace.size() ? text_of(trace[j].command) : "its end");
  };
  // Two blocks in a row must agree (or one at the end), so that a repeated word alone does not pass for it.
  const auto agree = [&](std::size_t i, std::size_t j) {
    if (i >= program.size() || j >= trace.size() || !same(program[i], trace[j].command)) return false;
    return i + 1 == program.size() || j + 1 == trace.size() || same(program[i + 1], trace[j + 1].command);
  };
  std::size_t i = 0, j = 0;
  while (i < program.size() && j < trace.size()) {
    if (same(program[i], trace[j].command)) {
      ++i, ++j;
      continue;
    }
    const std::size_t skipped = first_agreement(std::min(kResyncBlocks, program.size() - i),
                                                [&](std::size_t k) { return agree(i + k, j); });
    const std::size_t limit = skipped > 0 ? skipped : kResyncBlocks;
    const std::size_t extra =
        first_agreement(std::min(limit, trace.size() - j), [&](std::size_t k) { return agree(i, j + k); });
    if (agree(i + 1, j + 1) || (skipped == 0 && extra == 0)) {
      note(i, j, "altered");
      ++check.altered, ++i, ++j;
    } else if (skipped > 0 && (extra == 0 || skipped <= extra)) {
      note(i, j, std::to_string(skipped) + " not executed");
      check.missing += skipped, i += skipped;
    } else {
      note(i, j, std::to_string(extra) + " executed twice or never sent");
      check.repeated += extra, j += extra;
    }
  }
  if (i == program.size() && j + 1 == trace.size() && is_barrier(trace[j].command)) ++j, --check.executed;
  if (i < program.size()) note(i, j, std::to_string(program.size() - i) + " not executed");
  if (j < trace.size()) note(i, j, std::to_string(trace.size() - j) + " executed after the end");
  check.missing += program.size() - i, check.repeated += trace.size() - j;
  return check;
}

}  // namespace tiltfeed::sim
