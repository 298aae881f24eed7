// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Data of the page of `serve`, shared by the thread that receives the model's results and the threads of the page's
// server (page_server_module.cpp). Readers take the newest moment. A reader that lags skips moments and blocks nobody.

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>

namespace thermotwin::tools {

struct PageFeed {
  std::mutex mutex;
  std::condition_variable changed;
  std::string page;        ///< HTML
  std::string now = "{}";  ///< JSON of the newest moment
  /// JSON of the last 24 h; called with the mutex held.
  std::function<std::string()> history = [] { return std::string(R"({"points":[],"fields":[]})"); };
  std::uint64_t version = 0;  ///< of now; 0: none has come
  bool ended = false;
  std::atomic<int> readers{0};  ///< of the events, at the moment
};

/// Starts the server on 127.0.0.1 in a thread of its own. @param feed  must outlive the process's end of serving
/// @return the port, or -1 where it cannot be had
using StartPageServer = int (*)(int port, PageFeed* feed);
inline constexpr const char* start_page_server_name = "thermotwin_start_page_server";

}  // namespace thermotwin::tools
