#pragma once
// The bytes of a program file, piece by piece, always the same ones: what was read once and hashed is what
// every later pass gives, or an error.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "daemon/files/sha256.h"
#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

/// Properties: from the second pass after keep() on, no byte is given out that differs from that pass.
class ProgramFile {
 public:
  static constexpr std::size_t kPiece = 65536;

  /// Errors: kIo; kInput when it is not a regular file (it is read twice).
  static Result<ProgramFile> open(const std::string& path);
  ProgramFile(ProgramFile&& other) noexcept;
  ProgramFile& operator=(ProgramFile&& other) noexcept;
  ~ProgramFile();

  /// The digests of the pass that begins are kept. Requires: at the begin.
  void keep();
  /// The next piece, kPiece bytes but for the last; 0: the end. Errors: kIo, also where it is not the piece
  /// that was read before.
  Result<std::size_t> read(char* to);
  /// Reads what is left for its digests, and gives the digest of the whole file. Requires: keep().
  Result<std::array<std::uint8_t, 32>> finish();
  /// Errors: kIo.
  Result<void> rewind();

 private:
  ProgramFile(std::string path, int fd) : path_(std::move(path)), fd_(fd) {}
  tl::unexpected<Error> changed() const;

  std::string path_;
  int fd_ = -1;
  bool keeps_ = false, known_ = false;  // digests are taken; all of them are
  std::size_t piece_ = 0;               // that comes next
  std::vector<std::array<std::uint8_t, 32>> pieces_;
  Sha256Sum sum_;
};

}  // namespace tiltfeed::daemon
