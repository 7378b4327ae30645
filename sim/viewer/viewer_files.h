#pragma once
// The viewer's program for the browser: desk/page/src/report_main.ts and what it uses, bundled when this
// program was built.

#include <string_view>

namespace tiltfeed::sim {

struct ViewerFiles {
  std::string_view script_gzip;  ///< compressed; empty: built without the page
  std::string_view script_hash;  ///< "sha256-...", of the script, for a content security policy
  std::string_view style;        ///< CSS
};

ViewerFiles viewer_files();

}  // namespace tiltfeed::sim
