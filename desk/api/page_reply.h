#pragma once
// The page's own files as replies.

#include "desk/http/http_message.h"

namespace tiltfeed::desk {

/// Compressed where the client takes that; 304 where it has the bytes already; 404.
Reply page_reply(const Request& request);

}  // namespace tiltfeed::desk
