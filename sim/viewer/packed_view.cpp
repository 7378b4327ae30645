#include "sim/viewer/packed_view.h"

#include <zlib.h>

namespace tiltfeed::sim {
namespace {

constexpr int kGzip = 15 + 16;  // the largest window, and a gzip header
constexpr int kMemory = 9;

std::string gzip(const std::string& bytes) {
  z_stream stream{};
  if (deflateInit2(&stream, Z_DEFAULT_COMPRESSION, Z_DEFLATED, kGzip, kMemory, Z_DEFAULT_STRATEGY) != Z_OK)
    return {};
  std::string out(deflateBound(&stream, bytes.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  const bool whole = deflate(&stream, Z_FINISH) == Z_STREAM_END;
  out.resize(whole ? stream.total_out : 0);
  deflateEnd(&stream);
  return out;
}

}  // namespace

void PackedView::note(std::string_view name, const char* type, std::size_t at, std::size_t count) {
  arrays_ += (arrays_.empty() ? "\"" : ", \"") + std::string(name) + "\": {\"type\": \"" + type +
             "\", \"at\": " + std::to_string(at) + ", \"count\": " + std::to_string(count) + "}";
}

void PackedView::add_steps(std::string_view name, std::span<const std::uint32_t> numbers) {
  std::vector<std::uint32_t> steps(numbers.begin(), numbers.end());
  for (std::size_t i = steps.size(); i-- > 1;) steps[i] -= steps[i - 1];
  put(name, "steps", std::span<const std::uint32_t>(steps));
}

std::string PackedView::packed(const std::string& facts) const {
  std::string head = "{" + facts + (facts.empty() ? "" : ", ") + "\"arrays\": {" + arrays_ + "}}";
  head.resize((head.size() + 3) / 4 * 4, ' ');
  const auto length = static_cast<std::uint32_t>(head.size());
  std::string all(sizeof length, '\0');
  std::memcpy(all.data(), &length, sizeof length);
  return gzip(all + head + bytes_);
}

std::string unzipped(std::string_view gzip) {
  z_stream stream{};
  if (inflateInit2(&stream, kGzip) != Z_OK) return {};
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(gzip.data()));
  stream.avail_in = static_cast<uInt>(gzip.size());
  std::string out;
  int state = Z_OK;
  while (state == Z_OK) {
    constexpr std::size_t kBlock = 1 << 18;
    const std::size_t at = out.size();
    out.resize(at + kBlock);
    stream.next_out = reinterpret_cast<Bytef*>(out.data() + at);
    stream.avail_out = kBlock;
    state = inflate(&stream, Z_NO_FLUSH);
    out.resize(at + kBlock - stream.avail_out);
  }
  inflateEnd(&stream);
  return state == Z_STREAM_END ? out : std::string();
}

std::string base64(std::string_view bytes) {
  static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve(bytes.size() * 4 / 3 + 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t word = 0;
    for (std::size_t k = 0; k < 3; ++k)
      word = word << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k)
      out += i + k <= bytes.size() ? kDigits[word >> (18 - 6 * k) & 63U] : '=';
  }
  return out;
}

}  // namespace tiltfeed::sim
