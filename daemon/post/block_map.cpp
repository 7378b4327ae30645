#include "daemon/post/block_map.h"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <ostream>

namespace tiltfeed::daemon {

namespace {

constexpr char kMapMark[8] = {'T', 'F', 'M', 'A', 'P', '1', '\n', '\0'};
constexpr std::size_t kEntryBytes = 8;  // move, facet: little-endian, 4 bytes each

void put(char* out, std::uint32_t value) {
  for (int i = 0; i < 4; ++i) out[i] = static_cast<char>(value >> (8 * i) & 0xFF);
}

std::uint32_t get(const char* in) {
  std::uint32_t value = 0;
  for (int i = 0; i < 4; ++i) value |= std::uint32_t{static_cast<unsigned char>(in[i])} << (8 * i);
  return value;
}

}  // namespace

void write_block_map(const Posting& posting, const std::vector<const ToolPath*>& paths, std::ostream& out) {
  out.write(kMapMark, sizeof kMapMark);
  char entry[kEntryBytes];
  auto path = paths.begin();
  for (const Operation& op : posting.operations) {
    if (&op != posting.operations.data() && !op.goes_on) ++path;
    const std::vector<Move>& moves = (*path)->moves;
    for (const JointMove& block : op.words->moves) {
      put(entry, block.move);
      put(entry + 4, block.move < moves.size() ? moves[block.move].facet : kNoFacet);
      out.write(entry, kEntryBytes);
    }
  }
}

Result<std::optional<BlockOrigin>> read_block_origin(const std::string& path, std::uint64_t number) {
  std::ifstream in(path, std::ios::binary);
  if (!in) return fail(Code::kIo, path + ": " + std::strerror(errno));
  char mark[sizeof kMapMark];
  if (!in.read(mark, sizeof mark) || std::memcmp(mark, kMapMark, sizeof mark) != 0)
    return fail(Code::kInput, path + ": is not a map of blocks");
  if (number == 0) return std::optional<BlockOrigin>();
  in.seekg(static_cast<std::streamoff>(sizeof kMapMark + (number - 1) * kEntryBytes));
  char entry[kEntryBytes];
  if (!in.read(entry, kEntryBytes)) return std::optional<BlockOrigin>();
  return std::optional<BlockOrigin>(BlockOrigin{get(entry), get(entry + 4)});
}

}  // namespace tiltfeed::daemon
