#include "sim/report/program_header.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <sstream>

#include "pathgen/mesh/mesh.h"
#include "sim/gcode/lines.h"
#include "sim/motion/forward.h"

namespace tiltfeed::sim {
namespace {

constexpr int kMostLines = 50;
// The header prints lengths with a few decimals.
constexpr double kSameLength = 1e-3;
// A trace prints words to 1e-6, and no lever is longer than a few metres, mm.
constexpr double kSamePlace = 1e-3;

/// With all the digits that the header prints: two lengths that differ must look it.
std::string length_text(double mm) {
  std::array<char, 32> text;
  std::snprintf(text.data(), text.size(), "%.10g mm", mm);
  return text.data();
}

std::string place_text(Vec3 v) {
  return "(" + number_text(v.x) + ", " + number_text(v.y) + ", " + number_text(v.z) + ") mm";
}

/// `TILTFEED part zero X Y Z mm`, and nothing after it: the part's own line ends with the tool.
bool read_part_zero(const std::string& text, ProgramHeader& header) {
  std::istringstream words(text);
  std::string mark, part, zero, unit, more;
  Vec3 at;
  if (!(words >> mark >> part >> zero >> at.x >> at.y >> at.z >> unit) || zero != "zero" || unit != "mm" ||
      words >> more)
    return false;
  header.part_zero = at;
  return true;
}

}  // namespace

ProgramHeader read_program_header(std::istream& in) {
  ProgramHeader header;
  Lines lines(in);
  for (int i = 0; i < kMostLines; ++i) {
    const auto next = lines.next();
    if (!next) break;
    const std::string line(*next);
    const std::size_t open = line.find("TILTFEED ");
    // Heidenhain text numbers its comments, too.
    const std::size_t comment = line.find_first_of("(;");
    if (open == std::string::npos || comment > open) continue;
    std::string stated = line.substr(open, line.find(')') - open);
    while (!stated.empty() && (stated.back() == '*' || stated.back() == '\r')) stated.pop_back();
    std::istringstream words(stated);
    std::string mark, key, word;
    words >> mark >> key;
    if (key == "machine") {
      std::getline(words >> std::ws, header.machine);
    } else if (key == "blocks") {
      std::uint64_t count = 0;
      double seconds = 0.0;
      if (words >> count) header.blocks = count;
      if (words >> word >> seconds && word == "time") header.seconds = seconds;
    } else if (key == "part" && read_part_zero(words.str(), header)) {
      continue;
    } else if (key == "part") {
      // NAME may hold blanks; the tool's D and L words follow it.
      while (words >> word) {
        char* end = nullptr;
        const double value = word.size() > 1 ? std::strtod(word.c_str() + 1, &end) : 0.0;
        const bool number = end != nullptr && *end == '\0';
        if (number && word[0] == 'D')
          header.diameter = value;
        else if (number && word[0] == 'L')
          header.length = value;
        else
          header.part += (header.part.empty() ? "" : " ") + word;
      }
    }
  }
  return header;
}

Result<void> check_header(const ProgramHeader& header, const config::Job& job, const std::string& name) {
  const auto other = [&](const std::string& what, const std::string& is, const std::string& wanted) {
    return fail(Code::kInput, name + ": the program was posted for " + what + " " + is + ", and " + job.path +
                                  " has " + wanted + ": verify it with its own job, or post it again");
  };
  if (!header.machine.empty() && header.machine != job.machine.model.name)
    return other("machine", header.machine, job.machine.model.name);
  if (!header.part.empty() && header.part != job.plan.name) return other("part", header.part, job.plan.name);
  if (header.part_zero && length(*header.part_zero - job.setup.part_zero) > kSameLength)
    return other("part zero", place_text(*header.part_zero), place_text(job.setup.part_zero));
  const pathgen::Cutter& cutter = job.plan.cutter;
  if (header.diameter && std::abs(*header.diameter - cutter.diameter) > kSameLength)
    return other("a tool of diameter", length_text(*header.diameter), length_text(cutter.diameter));
  if (header.length && std::abs(*header.length - cutter.length) > kSameLength)
    return other("a tool of length", length_text(*header.length), length_text(cutter.length));
  return {};
}

Result<void> check_tool(const Block& block, const config::Job& job, const std::string& name) {
  const int wanted = job.program.tool;
  const bool feed = block.op == Op::kFeed;
  if ((!feed && block.op != Op::kRapid) || block.tool == kToolNotSaid || block.tool == wanted) return {};
  if (block.tool == 0 && !feed) return {};
  const std::string place =
      name + ": line " + std::to_string(block.line) + " moves with tool T" + std::to_string(block.tool);
  if (wanted == 0)
    return fail(Code::kInput, place + ", and " + job.path +
                                  " does not say which tool of the magazine its cutter is: state " +
                                  "program.tool there, if it is this one");
  return fail(Code::kInput, place + ", and " + job.path + " has the cutter of tool " +
                                std::to_string(wanted) +
                                " (program.tool): verify it with the job of that tool, one tool a program");
}

Result<void> check_tool(const std::vector<Block>& program, const config::Job& job, const std::string& name) {
  for (const Block& block : program)
    if (auto fits = check_tool(block, job, name); !fits) return fits;
  return {};
}

Result<void> check_trace(const std::vector<TraceRow>& trace, const config::Job& job,
                         const std::string& name) {
  const FrameChain chain(job.machine.model, job.setup);
  for (const TraceRow& row : trace) {
    const Op op = row.command.op;
    if (op != Op::kRapid && op != Op::kFeed) continue;
    const Point<Part> tip = chain(row.command.target).tip;
    if (distance(tip, row.pose.tip) <= kSamePlace) continue;
    return fail(Code::kInput, name + ": block " + std::to_string(row.block) + " has the tip at " +
                                  place_text(from_origin(row.pose.tip)) + ", and by " + job.path +
                                  " it is at " + place_text(from_origin(tip)) +
                                  ": it is the trace of another machine, part zero or tool length");
  }
  return {};
}

}  // namespace tiltfeed::sim
