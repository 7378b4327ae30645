#include "sim/viewer/viewer_files.h"

namespace tiltfeed::sim {

ViewerFiles viewer_files() { return {}; }

}  // namespace tiltfeed::sim
