#include "daemon/service/entry_hold.h"

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

namespace tiltfeed::daemon {
namespace {

constexpr std::string_view kSpeaker = "tiltfeed-sim prove: ", kName = "the way in";
constexpr const char* kModes = "G21 G90 G17 G40 G49 G54 G94\n";

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
                                 "--threads", "1"};
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

}  // namespace

Result<std::string> hold_entry(const Reentry& entry, const EntrySetup& setup) {
  if (setup.job.empty())
    return not_held("the program was handed in by itself, without a job that states them");
  const std::string start = entry.as_it_stands ? "" : kModes, end = "M30\n";
  std::string text = start + entry.from + entry.held + end, note;
  auto verdict = prove(text, setup);
  const std::size_t off = start.empty() ? 0 : 1;
  // Where it stands it may be in the part: the way off from there is the first two lines.
  if (verdict && verdict->gouges && !entry.from.empty() && verdict->line <= off + 2) {
    note =
        "; where it stands now the tool is in the part, so that its way off from there is not held against "
        "it";
    text = start + entry.held + end;
    verdict = prove(text, setup);
  }
  if (!verdict) return not_held(verdict.error().message);
  if (verdict->clear)
    return "held against part, fixtures and machine: the way in keeps clear" +
           std::string(entry.from.empty() ? " from its first place on (where it stands is not reported)"
                                          : "") +
           note + "\n";
  if (!verdict->collides && !verdict->gouges) return not_held(verdict->said);
  return fail(Code::kInput,
              "the way in is refused at its line '" + line_of(text, verdict->line) + "': " + verdict->said +
                  "; nothing has moved: take the tool clear by hand to where the way is free, or "
                  "enter at another block");
}

}  // namespace tiltfeed::daemon
