#include "daemon/plan/proof_process.h"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <string_view>

namespace tiltfeed::daemon {
namespace {

constexpr std::string_view kSpeaker = "tiltfeed-sim prove: ", kCollision = ": collision: ";

}  // namespace

Result<ProofProcess> ProofProcess::start(const ProofRequest& request, int program) {
  const auto prover = config::program_beside("tiltfeed-sim");
  if (!prover) return tl::unexpected(prover.error());
  std::vector<std::string> words{
      *prover,  "prove",      request.job, "/dev/fd/" + std::to_string(config::HeardProcess::kFile),
      "--name", request.name, "--told",    "--progress"};
  const std::pair<const char*, const std::string&> stated[] = {{"--stl", request.stl},
                                                               {"--machine", request.machine},
                                                               {"--operation", request.operation},
                                                               {"--picture", request.picture}};
  for (const auto& [option, value] : stated)
    if (!value.empty()) words.emplace_back(option), words.push_back(value);
  config::HeardProcess process;
  if (const int failed = process.start(words, program, true); failed != 0)
    return fail(Code::kIo,
                *prover + ": " + std::strerror(failed) +
                    "; it proves programs and belongs beside tiltfeed: install both, or state --no-proof");
  return ProofProcess(std::move(process));
}

/// "place OPERATION RAPID LINE X Y Z A C BODIES", "gouge OPERATION RAPID X Y Z".
bool ProofProcess::take_place(const std::string& line) {
  CollisionFound place;
  GougeFound gouge;
  int rapid = 0, read = 0;
  Joints& at = place.words;
  if (std::sscanf(line.c_str(), "place %zu %d %u %lf %lf %lf %lf %lf %n", &place.operation, &rapid,
                  &place.line, &at.x, &at.y, &at.z, &at.a, &at.c, &read) == 8) {
    place.rapid = rapid != 0;
    place.bodies = line.substr(static_cast<std::size_t>(read));
    places_.push_back(std::move(place));
    return true;
  }
  if (std::sscanf(line.c_str(), "gouge %zu %d %lf %lf %lf", &gouge.operation, &rapid, &gouge.tip.x,
                  &gouge.tip.y, &gouge.tip.z) != 5)
    return false;
  gouge.rapid = rapid != 0;
  gouge_ = gouge;
  return true;
}

Result<ProofFigures> ProofProcess::finish(const StageProgress& progress) {
  process_.tell("go\n");
  std::string said;
  const auto heard = process_.listen(progress, [&](const std::string& line) {
    if (!take_place(line)) said += (said.empty() ? "" : "\n") + line;
  });
  if (!heard) return tl::unexpected(heard.error());
  const int status = process_.wait();
  ProofFigures figures;
  unsigned long long moves = 0;
  if (status == 0 &&
      std::sscanf(said.c_str(), "proven %llu moves, largest gouge %lf mm", &moves, &figures.gouge) == 2) {
    figures.moves = moves;
    if (const auto end = said.find('\n'); end != said.npos) figures.collisions = said.substr(end + 1);
    return figures;
  }
  if (const auto at = said.find(kCollision); at != said.npos) {
    collision_ = said.substr(at + kCollision.size());
    collision_.resize(std::min(collision_.find('\n'), collision_.size()));
  }
  return fail(Code::kInput,
              "not proven, nothing was written: " + config::last_word_of(std::move(said), kSpeaker, status));
}

}  // namespace tiltfeed::daemon
