#include "daemon/plan/header_figures.h"

#include <unistd.h>

#include <array>
#include <cstdio>

namespace tiltfeed::daemon {
namespace {

constexpr std::size_t kHeader = 8192;  // bytes in which that word is

}  // namespace

std::string head_of(config::OutputFile& file) {
  std::string head(kHeader, '\0');
  const ssize_t size = ::pread(file.descriptor(), head.data(), head.size(), 0);
  head.resize(size > 0 ? static_cast<std::size_t>(size) : 0);
  return head;
}

Result<void> state_figures(config::OutputFile& file, const ProofFigures& figures) {
  const std::string text = head_of(file);
  const std::size_t at = text.find(kNotProvenYet);
  if (at == text.npos) return fail(Code::kIo, "the program's header has no place for the proof's figures");
  std::array<char, 80> words;
  std::snprintf(words.data(), words.size(), "proof gouge %.4f mm moves %llu", figures.gouge,
                static_cast<unsigned long long>(figures.moves));
  std::string filled = words.data();
  filled.resize(kNotProvenYet.size(), ' ');
  return file.overwrite(at, filled);
}

}  // namespace tiltfeed::daemon
