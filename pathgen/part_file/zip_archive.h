#pragma once
// A ZIP archive in memory, as 3MF files are: entries by name, inflated within limits.

#include <cstdint>
#include <map>
#include <span>
#include <string>

#include "kinematics/basics/result.h"

namespace tiltfeed::pathgen {

/// Bytes that one entry may have when inflated, whatever it says of itself.
inline constexpr std::uint64_t kMaxInflated = 1ull << 30;
inline constexpr std::size_t kMaxZipEntries = 10'000;

class ZipArchive {
 public:
  /// `bytes` must outlive the object. Errors: kInput: no directory, cut short, parts of several;
  /// kLimit over kMaxZipEntries.
  static Result<ZipArchive> open(std::span<const char> bytes, const std::string& file);

  bool has(const std::string& name) const { return entries_.contains(name); }
  /// Errors: kInput: not there, encrypted, another method than deflate, damaged (size, check sum); kLimit:
  /// more than kMaxInflated. Memory grows with what is inflated, not with what is said.
  Result<std::string> read(const std::string& name) const;

 private:
  struct Entry {
    std::uint32_t flags = 0, method = 0, check_sum = 0;
    std::uint64_t packed = 0, size = 0, header = 0;
  };
  ZipArchive(std::span<const char> bytes, std::string file) : bytes_(bytes), file_(std::move(file)) {}
  Result<std::string> inflated(const Entry& entry, std::span<const char> packed,
                               const std::string& name) const;

  std::span<const char> bytes_;
  std::string file_;
  std::map<std::string, Entry> entries_;
};

}  // namespace tiltfeed::pathgen
