#pragma once
// An empty document of OpenCASCADE's for what is read, and the bytes of a file.

#include <string>

#include "kinematics/basics/result.h"

class TDocStd_Document;
namespace opencascade {
template <class T>
class handle;
}

namespace tiltfeed::cad {

/// OpenCASCADE says nothing on standard output from now on, and gives lengths in mm.
opencascade::handle<TDocStd_Document> new_document();

/// Errors: kIo; kLimit over 512 MiB.
Result<std::string> file_text(const std::string& path);

}  // namespace tiltfeed::cad
