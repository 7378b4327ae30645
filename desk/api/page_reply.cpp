#include "desk/api/page_reply.h"

#include <zlib.h>

#include <array>
#include <string>

#include "desk/page/page_files.h"

namespace tiltfeed::desk {
namespace {

/// Requires: `gzip` is what the build made.
std::string inflated(std::string_view gzip) {
  z_stream stream{};
  constexpr int kGzip = 16 + MAX_WBITS;
  if (inflateInit2(&stream, kGzip) != Z_OK) return {};
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(gzip.data()));
  stream.avail_in = static_cast<uInt>(gzip.size());
  std::string text;
  std::array<char, 16384> block{};
  int state = Z_OK;
  while (state == Z_OK) {
    stream.next_out = reinterpret_cast<Bytef*>(block.data());
    stream.avail_out = static_cast<uInt>(block.size());
    state = inflate(&stream, Z_NO_FLUSH);
    text.append(block.data(), block.size() - stream.avail_out);
  }
  inflateEnd(&stream);
  return text;
}

}  // namespace

Reply page_reply(const Request& request) {
  for (const PageFile& file : page_files()) {
    if (request.path != file.path) continue;
    Reply reply;
    reply.type = file.type;
    reply.headers = {
        {"Cache-Control", "no-cache"}, {"ETag", std::string(file.etag)}, {"Vary", "Accept-Encoding"}};
    if (request.if_none_match == file.etag) {
      reply.status = 304;
    } else if (accepts_gzip(request.accept_encoding)) {
      reply.bytes = file.gzip;
      reply.headers.emplace_back("Content-Encoding", "gzip");
    } else {
      reply.body = inflated(file.gzip);
    }
    return reply;
  }
  return refusal(404, "there is no such page");
}

}  // namespace tiltfeed::desk
