#pragma once
// The page: its files, bundled and compressed when the program was built.

#include <span>
#include <string_view>

namespace tiltfeed::desk {

struct PageFile {
  std::string_view path;  ///< "/", "/page.js", ...
  std::string_view type;  ///< of its content
  std::string_view etag;  ///< in quotes; changes with the bytes
  std::string_view gzip;  ///< the bytes, compressed
};

std::span<const PageFile> page_files();

}  // namespace tiltfeed::desk
