#include "daemon/service/entry_hold.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <sstream>
#include <string_view>
#include <utility>
#include <vector>

#include "config/child_process.h"
#include "daemon/journal/in_force.h"
#include "daemon/machine/advice.h"
#include "daemon/machine/machine_place.h"
#include "daemon/program/line_reader.h"
#include "daemon/program/numeric_block.h"
#include "daemon/wire/open_link.h"
#include "daemon/wire/steady_clock.h"
#include "kinematics/basics/decimal.h"

namespace tiltfeed::daemon {
namespace {

constexpr std::string_view kSpeaker = "tiltfeed-sim prove: ", kName = "the way in";
constexpr const char *kModes = "G21 G90 G17 G40 G49 G54 G94\n", *kEnd = "M30\n";
constexpr const char* kClear = "held against part, fixtures and machine: the way in keeps clear";

/// What the prover says of a text.
struct Verdict {
  bool clear = false, collides = false, gouges = false;
  std::size_t line = 0;  ///< of the text, from 1
  std::string said;      ///< without name and line
};

std::string line_of(const std::string& text, std::size_t number) {
  std::istringstream in(text);
  std::string line;
  for (std::size_t i = 0; i < number && std::getline(in, line); ++i) continue;
  return line;
}

Verdict read_verdict(std::string said, int status) {
  Verdict verdict;
  verdict.clear = status == 0;
  verdict.said = config::last_word_of(std::move(said), kSpeaker, status);
  const std::string head = std::string(kName) + ":";
  if (!verdict.said.starts_with(head)) return verdict;
  char* end = nullptr;
  verdict.line = std::strtoull(verdict.said.c_str() + head.size(), &end, 10);
  verdict.said = std::strncmp(end, ": ", 2) == 0 ? end + 2 : end;
  verdict.collides = verdict.said.starts_with("collision: ");
  verdict.gouges = verdict.said.starts_with("gouge: ");
  return verdict;
}

/// Errors: kIo.
Result<Verdict> prove(const std::string& text, const EntrySetup& setup) {
  const auto prover = config::program_beside("tiltfeed-sim");
  if (!prover) return tl::unexpected<Error>(prover.error());
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::tmpfile(), std::fclose);
  if (!file || std::fwrite(text.data(), 1, text.size(), file.get()) != text.size() ||
      std::fflush(file.get()) != 0)
    return fail(Code::kIo, std::string("a temporary file: ") + std::strerror(errno));
  std::rewind(file.get());
  std::vector<std::string> words{*prover,     "prove",
                                 setup.job,   "/dev/fd/" + std::to_string(config::HeardProcess::kFile),
                                 "--name",    std::string(kName),
                                 "--machine", setup.machine,
                                 "--threads", "1",
                                 "--closed"};
  for (const auto& [option, value] :
       {std::pair<const char*, const std::string&>{"--stl", setup.stl}, {"--operation", setup.operation}})
    if (!value.empty()) words.emplace_back(option), words.push_back(value);
  config::HeardProcess process;
  if (const int failed = process.start(words, ::fileno(file.get())); failed != 0)
    return fail(Code::kIo, *prover + ": " + std::strerror(failed));
  std::string said;
  const auto heard =
      process.listen({}, [&](const std::string& line) { said += (said.empty() ? "" : "\n") + line; });
  if (!heard) return tl::unexpected<Error>(heard.error());
  return read_verdict(std::move(said), process.wait());
}

std::string not_held(const std::string& why) {
  return "not held against part, fixtures and machine: " + why + "; look at the way that the lines go\n";
}

/// A way in. `from`: the place and the moves that it begins with, where the tool may be in the part.
struct WayIn {
  std::string head, from, rest;
  bool stands = false;  ///< where the machine stands is in it
  std::string advice;   ///< what to do where it is refused
};

/// As hold_entry.
Result<std::string> hold(const WayIn& way, const EntrySetup& setup) {
  std::string text = way.head + way.from + way.rest + kEnd, note;
  auto verdict = prove(text, setup);
  // Where it stands it may be in the part: the way off from there is in the lines of `from`.
  const auto lines = static_cast<std::size_t>(std::ranges::count(way.head + way.from, '\n'));
  if (verdict && verdict->gouges && !way.from.empty() && verdict->line <= lines) {
    note =
        "; where it stands now the tool is in the part, so that its way off from there is not held against "
        "it";
    text = way.head + way.rest + kEnd;
    verdict = prove(text, setup);
  }
  if (!verdict) return not_held(verdict.error().message);
  if (verdict->clear)
    return kClear +
           std::string(way.stands ? "" : " from its first place on (where it stands is not reported)") +
           note + "\n";
  if (!verdict->collides && !verdict->gouges) return not_held(verdict->said);
  return fail(Code::kInput, "the way in is refused at its line '" + line_of(text, verdict->line) +
                                "': " + verdict->said + "; nothing has moved: " + way.advice);
}

/// The moves of a program until it has stated where every axis is. Errors: kInput: a line that is not
/// understood before that.
Result<std::string> moves_to_first_place(const std::string& path, const MachineModel& machine) {
  Result<LineReader> program = LineReader::open(path);
  if (!program) return tl::unexpected<Error>(program.error());
  BlockReader reader(numeric_axes(machine), true);
  InForce now;
  std::string moves;
  std::vector<NumericBlock> blocks;
  for (Line line; !now.is_placed(machine);) {
    const Result<bool> more = program->next(line);
    if (!more) return tl::unexpected<Error>(more.error());
    if (!*more) break;
    blocks.clear();
    if (const Result<void> read = reader.read(line, blocks); !read)
      return fail(Code::kInput,
                  "line " + std::to_string(line.number) + ": '" + line.text + "': " + read.error().message);
    now.take_words(line.text);
    for (const NumericBlock& block : blocks) now.take(block);
    const bool goes = std::ranges::any_of(blocks, [](const NumericBlock& block) {
      return block.op == BlockOp::kRapid || block.op == BlockOp::kFeed;
    });
    if (goes || line.text.starts_with("G9")) moves += line.text + "\n";
  }
  return moves;
}

/// A feed to where the machine stands: held it is from there on.
std::string place_line(const config::MachineProfile& machine, const Joints& at) {
  const config::ProgramFormat& format = machine.format;
  std::string line = "G1";
  const auto word = [&](char letter, double value, int decimals) {
    line += std::string(" ") + letter + decimal(value, decimals);
  };
  word('X', at.x, format.linear_decimals), word('Y', at.y, format.linear_decimals);
  word('Z', at.z, format.linear_decimals);
  if (machine.model.tilt.present) word(machine.model.tilt.letter, at.a, format.rotary_decimals);
  if (machine.model.rotary.present) word(machine.model.rotary.letter, at.c, format.rotary_decimals);
  return line + " F100\n";
}

}  // namespace

Result<std::string> hold_entry(const Reentry& entry, const EntrySetup& setup) {
  if (setup.job.empty())
    return not_held("the program was handed in by itself, without a job that states them");
  return hold({entry.as_it_stands ? "" : kModes, entry.from, entry.held, !entry.from.empty(),
               "take the tool clear by hand to where the way is free, or enter at another block"},
              setup);
}

Result<std::string> hold_start(const std::string& program, const config::MachineProfile& machine,
                               const Joints& stands, const EntrySetup& setup, LinkKind link) {
  const Result<std::string> moves = moves_to_first_place(program, machine.model);
  if (!moves) return not_held(moves.error().message);
  // No tool begins in the part: unlike at an entry nothing was cut yet, and it can be taken off by hand.
  return hold(
      {kModes + place_line(machine, stands), "", *moves, true, way_free_advice(link) + ", then start again"},
      setup);
}

Result<std::string> hold_way_back(const std::string& way, const config::MachineProfile& machine,
                                  const Joints& stands, const EntrySetup& setup, LinkKind link) {
  if (setup.job.empty())
    return not_held("the program was handed in by itself, without a job that states them");
  std::string moves;
  std::istringstream in(way);
  for (std::string line; std::getline(in, line);)
    if (line.starts_with("G0") || line.starts_with("G1") || line.starts_with("G53")) moves += line + "\n";
  return hold(
      {kModes + place_line(machine, stands), "", moves, true, way_free_advice(link) + ", then say it again"},
      setup);
}

Result<std::optional<Joints>> where_it_stands(const LinkSpec& link, const MachineModel& machine) {
  if (link.kind == LinkKind::kDrip || is_drive(link.kind)) return std::optional<Joints>();
  const Result<std::unique_ptr<Link>> wire = open_link(link);
  if (!wire) return tl::unexpected<Error>(wire.error());
  SteadyClock clock;
  if (const Result<void> can = takes_run(link, **wire, clock); !can)
    return tl::unexpected<Error>(can.error());
  return read_place(link, machine, **wire, clock);
}

}  // namespace tiltfeed::daemon
