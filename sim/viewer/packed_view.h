#pragma once
// Numbers for the viewer: a head in JSON and arrays, compressed as one.

#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace tiltfeed::sim {

/// Little-endian: the head's length (uint32), the head, blanks up to a multiple of 4, then the arrays, each
/// on a multiple of 4. The head is one JSON object; in "arrays" stands for each name its type, where it
/// begins behind the head, and how many numbers it has.
class PackedView {
 public:
  void add(std::string_view name, std::span<const float> numbers) { put(name, "f32", numbers); }
  void add(std::string_view name, std::span<const std::int16_t> numbers) { put(name, "i16", numbers); }
  void add(std::string_view name, std::span<const std::uint16_t> numbers) { put(name, "u16", numbers); }
  /// As differences from the number before, which compress well.
  void add_steps(std::string_view name, std::span<const std::uint32_t> numbers);

  /// gzip of all. `facts`: members of the head beside "arrays", as JSON without its outer braces.
  std::string packed(const std::string& facts) const;

 private:
  template <class Number>
  void put(std::string_view name, const char* type, std::span<const Number> numbers) {
    const std::size_t at = bytes_.size(), size = numbers.size() * sizeof(Number);
    bytes_.resize(at + (size + 3) / 4 * 4);
    if (size > 0) std::memcpy(bytes_.data() + at, numbers.data(), size);
    note(name, type, at, numbers.size());
  }
  void note(std::string_view name, const char* type, std::size_t at, std::size_t count);

  std::string bytes_, arrays_;
};

/// Errors are impossible for what these programs wrote themselves: an empty text then.
std::string unzipped(std::string_view gzip);
std::string base64(std::string_view bytes);

}  // namespace tiltfeed::sim
