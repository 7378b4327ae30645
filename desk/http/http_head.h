#pragma once
// The head of a request as libmicrohttpd has read it.

#include <cstdint>
#include <optional>
#include <string>

#include "desk/http/http_message.h"

struct MHD_Connection;

namespace tiltfeed::desk {

/// All of a request but its body.
Request head_of(MHD_Connection* connection, const char* url, const char* method);

}  // namespace tiltfeed::desk
