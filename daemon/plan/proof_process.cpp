#include "daemon/plan/proof_process.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <string_view>
#include <utility>
#include <vector>

#include "config/beside_program.h"

namespace tiltfeed::daemon {
namespace {

// In the process that is started; what it gets lies above, so that nothing is overwritten on the way.
constexpr int kProgram = 3, kFirstOwn = 10;
constexpr int kLook = 100;  // ms between looks at whether the user wants it to end
constexpr std::string_view kProgress = "progress ",
                           kSpeaker = "tiltfeed-sim prove: ", kCollision = ": collision: ";

/// A pipe whose ends lie above what the process that is started has.
bool open_pipe(std::array<int, 2>& ends) {
  std::array<int, 2> low{};
  if (::pipe2(low.data(), O_CLOEXEC) != 0) return false;
  for (std::size_t i = 0; i < 2; ++i) {
    ends[i] = ::fcntl(low[i], F_DUPFD_CLOEXEC, kFirstOwn);
    ::close(low[i]);
  }
  return ends[0] >= 0 && ends[1] >= 0;
}

void close_all(std::initializer_list<int> descriptors) {
  for (const int fd : descriptors)
    if (fd >= 0) ::close(fd);
}

}  // namespace

Result<ProofProcess> ProofProcess::start(const ProofRequest& request, int program) {
  const auto prover = config::program_beside("tiltfeed-sim");
  if (!prover) return tl::unexpected(prover.error());
  std::vector<std::string> words{*prover,  "prove",      request.job, "/dev/fd/" + std::to_string(kProgram),
                                 "--name", request.name, "--told",    "--progress"};
  const std::pair<const char*, const std::string&> stated[] = {{"--stl", request.stl},
                                                               {"--machine", request.machine},
                                                               {"--operation", request.operation},
                                                               {"--picture", request.picture}};
  for (const auto& [option, value] : stated)
    if (!value.empty()) words.emplace_back(option), words.push_back(value);
  std::array<int, 2> in{-1, -1}, out{-1, -1};
  const int text = ::fcntl(program, F_DUPFD_CLOEXEC, kFirstOwn);
  int pid = -1, failed = text < 0 || !open_pipe(in) || !open_pipe(out) ? errno : 0;
  if (failed == 0)
    failed = config::spawn_program(
        pid, words,
        {{in[0], STDIN_FILENO}, {out[1], STDOUT_FILENO}, {out[1], STDERR_FILENO}, {text, kProgram}});
  close_all({in[0], out[1], text});
  if (failed == 0) return ProofProcess(pid, in[1], out[0]);
  close_all({in[1], out[0]});
  return fail(Code::kIo,
              *prover + ": " + std::strerror(failed) +
                  "; it proves programs and belongs beside tiltfeed: install both, or state --no-proof");
}

ProofProcess::ProofProcess(ProofProcess&& other) noexcept
    : pid_(std::exchange(other.pid_, -1)),
      tell_(std::exchange(other.tell_, -1)),
      hear_(std::exchange(other.hear_, -1)),
      collision_(std::move(other.collision_)),
      places_(std::move(other.places_)),
      gouge_(other.gouge_) {}

ProofProcess::~ProofProcess() {
  close_all({tell_, hear_});
  if (pid_ < 0) return;
  ::kill(pid_, SIGKILL);
  while (::waitpid(pid_, nullptr, 0) < 0 && errno == EINTR) {
  }
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

/// All that it says but its progress, when it has ended.
Result<std::string> ProofProcess::listen(const StageProgress& progress) {
  std::string said, rest;
  double share = 0.0;
  while (true) {
    pollfd look{hear_, POLLIN, 0};
    const int ready = ::poll(&look, 1, kLook);
    if (progress && !progress(share)) return fail(Code::kCancelled, "cancelled; nothing was written");
    if (ready <= 0) continue;
    std::array<char, 4096> bytes;
    const ssize_t count = ::read(hear_, bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return said + rest;
    rest.append(bytes.data(), static_cast<std::size_t>(count));
    for (auto end = rest.find('\n'); end != rest.npos; end = rest.find('\n')) {
      const std::string line = rest.substr(0, end);
      rest.erase(0, end + 1);
      if (line.starts_with(kProgress))
        share = std::strtod(line.c_str() + kProgress.size(), nullptr);
      else if (!take_place(line))
        said += (said.empty() ? "" : "\n") + line;
    }
  }
}

Result<ProofFigures> ProofProcess::finish(const StageProgress& progress) {
  // If it has ended already it says why, and nobody hears this.
  const ssize_t told = ::write(tell_, "go\n", 3);
  static_cast<void>(told);
  auto said = listen(progress);
  if (!said) return tl::unexpected(said.error());
  int status = 0;
  while (::waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
  }
  pid_ = -1;
  ProofFigures figures;
  unsigned long long moves = 0;
  const bool proven = WIFEXITED(status) && WEXITSTATUS(status) == 0;
  if (proven &&
      std::sscanf(said->c_str(), "proven %llu moves, largest gouge %lf mm", &moves, &figures.gouge) == 2) {
    figures.moves = moves;
    if (const auto end = said->find('\n'); end != said->npos) figures.collisions = said->substr(end + 1);
    return figures;
  }
  if (const auto at = said->find(kCollision); at != said->npos) {
    collision_ = said->substr(at + kCollision.size());
    collision_.resize(std::min(collision_.find('\n'), collision_.size()));
  }
  if (said->starts_with(kSpeaker)) said->erase(0, kSpeaker.size());
  if (WIFSIGNALED(status)) *said += " (ended by signal " + std::to_string(WTERMSIG(status)) + ")";
  if (said->empty()) *said = "it ended with status " + std::to_string(status) + " and said nothing";
  return fail(Code::kInput, "not proven, nothing was written: " + *said);
}

}  // namespace tiltfeed::daemon
