// SPDX-License-Identifier: GPL-3.0-or-later
// The only file that includes cpp-httplib: the module of page_feed.h.

#include <chrono>
#include <httplib.h>
#include <string>
#include <sys/socket.h>
#include <thread>

#include "tools/serve/page_feed.h"

namespace thermotwin::tools {
namespace {

constexpr int connections = 64;                        ///< at the same time, each a thread
constexpr int most_event_readers = 32;                 ///< of these: the others answer one request each
constexpr int longest_request_s = 2;                   ///< for a request to come whole
constexpr auto still_there = std::chrono::seconds(3);  ///< a line without content tells whether the reader is gone

/// Pages of other sites must not read this one by a name of theirs that leads to 127.0.0.1.
bool is_local(const httplib::Request& request) {
  const std::string host = request.get_header_value("Host"), name = host.substr(0, host.rfind(':'));
  return name == "127.0.0.1" || name == "localhost";
}

void send_events(PageFeed& feed, httplib::Response& response) {
  response.set_header("Cache-Control", "no-store");
  if (++feed.readers > most_event_readers) {
    --feed.readers;
    response.status = 503;
    response.set_content("503: " + std::to_string(most_event_readers) + " readers follow the events already\n",
                         "text/plain");
    return;
  }
  response.set_chunked_content_provider(
      "text/event-stream",
      [&feed, seen = std::uint64_t{0}](std::size_t, httplib::DataSink& sink) mutable {
        std::string text = ": still there\n\n";
        {
          std::unique_lock lock(feed.mutex);
          feed.changed.wait_for(lock, still_there, [&] { return feed.version != seen || feed.ended; });
          if (feed.ended) return false;
          if (feed.version != seen) {
            seen = feed.version;
            text = "data: " + feed.now + "\n\n";
          }
        }
        return sink.write(text.data(), text.size());
      },
      [&feed](bool) { --feed.readers; });
}

}  // namespace
}  // namespace thermotwin::tools

extern "C" int thermotwin_start_page_server(int port, thermotwin::tools::PageFeed* feed) {
  using namespace thermotwin::tools;
  static httplib::Server server;
  server.new_task_queue = [] { return new httplib::ThreadPool(connections); };
  server.set_write_timeout(5, 0);
  server.set_read_timeout(longest_request_s, 0);
  server.set_keep_alive_timeout(longest_request_s);
  // The library's own options would let two servers share a port.
  server.set_socket_options([](int descriptor) {
    const int yes = 1;
    ::setsockopt(descriptor, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  });
  server.set_pre_routing_handler([](const httplib::Request& request, httplib::Response& response) {
    if (is_local(request)) return httplib::Server::HandlerResponse::Unhandled;
    response.status = 403;
    return httplib::Server::HandlerResponse::Handled;
  });
  const auto give = [feed](auto text, const char* type) {
    return [feed, text, type](const httplib::Request&, httplib::Response& response) {
      const std::lock_guard lock(feed->mutex);
      response.set_header("Cache-Control", "no-store");
      response.set_header("Readers", std::to_string(feed->readers));
      response.set_content(text(*feed), type);
    };
  };
  server.Get("/", give([](PageFeed& of) { return of.page; }, "text/html; charset=utf-8"));
  server.Get("/now", give([](PageFeed& of) { return of.now; }, "application/json"));
  server.Get("/history", give([](PageFeed& of) { return of.history(); }, "application/json"));
  server.Get("/events", [feed](const httplib::Request&, httplib::Response& response) { send_events(*feed, response); });
  const int bound =
      port > 0 ? (server.bind_to_port("127.0.0.1", port) ? port : -1) : server.bind_to_any_port("127.0.0.1");
  if (bound < 0) return -1;
  std::thread([] { server.listen_after_bind(); }).detach();
  return bound;
}
