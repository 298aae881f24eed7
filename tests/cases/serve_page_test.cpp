// SPDX-License-Identifier: GPL-3.0-or-later
// The page of `serve`: on this computer only, the same as JSON, in a browser without a window; a slow reader, a killed
// page process and a taken port end nothing.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <arpa/inet.h>
#include <array>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <future>
#include <sys/socket.h>
#include <thread>
#include <unistd.h>

#include "tests/cases/browser.h"
#include "tests/cases/served.h"
#include "tests/cases/toy.h"

namespace thermotwin::cases {
namespace {

sockaddr_in local(int port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return address;
}

/// A socket of 127.0.0.1. @param port  0: one that nobody has
class Tcp {
public:
  Tcp() : descriptor_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {}
  ~Tcp() { ::close(descriptor_); }
  Tcp(const Tcp&) = delete;
  Tcp& operator=(const Tcp&) = delete;

  int listen_anywhere() const {
    sockaddr_in address = local(0);
    socklen_t size = sizeof address;
    EXPECT_EQ(::bind(descriptor_, reinterpret_cast<sockaddr*>(&address), size), 0);
    EXPECT_EQ(::listen(descriptor_, 1), 0);
    EXPECT_EQ(::getsockname(descriptor_, reinterpret_cast<sockaddr*>(&address), &size), 0);
    return ntohs(address.sin_port);
  }
  bool connect(int port) const {
    const sockaddr_in address = local(port);
    return ::connect(descriptor_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  }
  void send(const std::string& text) const {
    EXPECT_EQ(::send(descriptor_, text.data(), text.size(), MSG_NOSIGNAL), std::ssize(text));
  }
  std::string rest() const {
    std::string text;
    char bytes[65536];
    for (ssize_t count = 0; (count = ::recv(descriptor_, bytes, sizeof bytes, 0)) > 0;) text.append(bytes, count);
    return text;
  }

private:
  int descriptor_;
};

int free_port() {
  const Tcp tcp;
  return tcp.listen_anywhere();
}

std::string get(const std::string& path, const std::string& host) {
  return "GET " + path + " HTTP/1.1\r\nHost: " + host + "\r\nConnection: close\r\n\r\n";
}

/// What the page answers; empty: nobody listens.
std::string fetched(int port, const std::string& path, const std::string& host = "127.0.0.1") {
  const Tcp tcp;
  if (!tcp.connect(port)) return "";
  tcp.send(get(path, host));
  return tcp.rest();
}

nlohmann::json json_of(const std::string& answer) {
  return nlohmann::json::parse(answer.substr(std::min(answer.size(), answer.find("\r\n\r\n") + 4)), nullptr, false);
}

/// The newest moment, once it is of that time.
nlohmann::json moment_at(int port, double time) {
  nlohmann::json moment;
  for (int i = 0; i < 400; ++i) {
    moment = json_of(fetched(port, "/now"));
    if (moment.is_object() && moment.value("time_s", -1.0) >= time) return moment;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  ADD_FAILURE() << "no moment at " << time << " s: " << moment;
  return moment;
}

class ServedPage : public Serve {
protected:
  ServedPage() : port_(free_port()), program_(arguments({"--port", std::to_string(port_)})) {
    program_.write(header);
    for (int i = 0; i <= 60; ++i) program_.write(warm_row(300.0 * i));
    for (int line = 0; line <= 61; ++line) program_.read_line();
  }
  /// T4 reads kelvin: a sensor that has failed, by name.
  static std::string warm_row(double time) {
    return fmt::format("{},6000,10,20.5,{:.2f},20.4,20.3,293.6\n", time, 25 + 0.01 * std::fmod(time / 60, 7));
  }
  /// Another two rows, the second one when the page takes a new moment again.
  void go_on_to(double time) {
    program_.write(warm_row(time));
    program_.read_line();
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    program_.write(warm_row(time + 1.5));
    program_.read_line();
  }

  int port_;
  Program program_;
};

TEST_F(ServedPage, GivesTheSameAsJson) {
  go_on_to(18060);
  const nlohmann::json now = moment_at(port_, 18061);
  EXPECT_EQ(now["model_is_up"], true);
  EXPECT_EQ(now["restarts"], 0);
  EXPECT_EQ(now["guard"], "following");
  ASSERT_EQ(now["sensors"].size(), 4U);
  EXPECT_EQ(now["sensors"][3]["id"], "T4");
  EXPECT_EQ(now["sensors"][3]["fault"], "kelvin");
  EXPECT_NEAR(now["sensors"][0]["reading_C"], 25.03, 0.04);
  EXPECT_NEAR(now["sensors"][0]["predicted_C"], 30.0, 15.0);
  EXPECT_GT(std::abs(double{now["offset_um"]["z"]}), 1.0);
  const nlohmann::json day = json_of(fetched(port_, "/history"));
  EXPECT_GE(day["points"].size(), 61U);
  EXPECT_LE(day["points"].size(), 63U);
  EXPECT_GE(day["fields"].size(), 61U);
  EXPECT_FALSE(day["fields"][0]["modes"].empty());
  EXPECT_EQ(program_.wait().status, 0);
}

TEST_F(ServedPage, IsLocalAndNeedsNothingFromElsewhere) {
  go_on_to(18060);
  moment_at(port_, 18061);
  EXPECT_SAYS(fetched(port_, "/", "evil.example"), "403");
  EXPECT_SAYS(fetched(port_, "/now", "evil.example:80"), "403");
  EXPECT_SAYS(fetched(port_, "/", "localhost:" + std::to_string(port_)), "200 OK");
  const std::string page = fetched(port_, "/");
  EXPECT_SAYS(page, "served-sensors");
  for (const char* outside : {"src=", "<link", "@import", "url(", "https://", "XMLHttpRequest"})
    EXPECT_EQ(page.find(outside), std::string::npos) << outside;
  EXPECT_LT(page.size(), 5U * 1024 * 1024);
  // Nobody listens on the other addresses of this computer.
  sockaddr_in other = local(port_);
  other.sin_addr.s_addr = htonl(0x7F000002);  // 127.0.0.2: bound to none, refused
  const int descriptor = ::socket(AF_INET, SOCK_STREAM, 0);
  EXPECT_NE(::connect(descriptor, reinterpret_cast<sockaddr*>(&other), sizeof other), 0);
  ::close(descriptor);
}

TEST_F(ServedPage, ASlowReaderHoldsUpNobody) {
  moment_at(port_, 0);
  std::array<Tcp, 5> slow;
  for (const Tcp& reader : slow) {
    ASSERT_TRUE(reader.connect(port_));
    reader.send("GET /events HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n");  // and nothing is read
  }
  for (int i = 1; i <= 1000; ++i) {
    program_.write(warm_row(18000 + i));
    ASSERT_EQ(served_of(program_.read_line()).time, 18000 + i);
  }
  go_on_to(20000);
  EXPECT_EQ(moment_at(port_, 20001)["model_is_up"], true);
  EXPECT_SAYS(fetched(port_, "/now"), "Readers: 5");
  EXPECT_EQ(program_.wait().status, 0);
}

// Whoever opens many connections gets 503, and does not keep the others from the page.
TEST_F(ServedPage, ManyConnectionsKeepNobodyFromThePage) {
  moment_at(port_, 0);
  {
    std::array<Tcp, 64> followers;
    for (const Tcp& reader : followers) {
      ASSERT_TRUE(reader.connect(port_));
      reader.send("GET /events HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n");
    }
    const auto begin = std::chrono::steady_clock::now();
    EXPECT_SAYS(fetched(port_, "/now"), "Readers: 32");
    EXPECT_SAYS(fetched(port_, "/events"), "503");
    EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(4));
  }
  std::array<Tcp, 80> half;
  for (const Tcp& reader : half) {
    ASSERT_TRUE(reader.connect(port_));
    reader.send("GET / HT");
  }
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_SAYS(fetched(port_, "/now"), "200 OK");
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(12));
  EXPECT_EQ(program_.wait().status, 0);
}

TEST_F(ServedPage, AKilledPageComesBackWithTheLastDay) {
  moment_at(port_, 0);
  EXPECT_EQ(kill_all("page"), 1);
  nlohmann::json day;
  for (int i = 0; i < 400 && (!day.is_object() || day["points"].size() < 61); ++i) {
    program_.write(warm_row(18001 + 0.1 * i));
    program_.read_line();
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    day = json_of(fetched(port_, "/history"));
  }
  EXPECT_GE(day["points"].size(), 61U);
  EXPECT_GE(day["fields"].size(), 60U);
  const Result result = program_.wait();
  EXPECT_EQ(result.status, 0);
  EXPECT_SAYS(result.err, "serve: the process of the page has ended (signal 9)");
}

nlohmann::json history_of(int port, std::size_t points) {
  nlohmann::json day;
  for (int i = 0; i < 400 && (!day.is_object() || day["points"].size() < points); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    day = json_of(fetched(port, "/history"));
  }
  return day;
}

// All processes die, as in a power cut, in the middle of a line.
TEST_F(ServedPage, TheLastDayOutlivesTheFront) {
  ASSERT_GE(history_of(port_, 60)["points"].size(), 60U);
  program_.send(SIGKILL);
  EXPECT_EQ(program_.wait().status, -SIGKILL);
  kill_all("model"), kill_all("page");
  const std::string before = read(state() + ".day");
  toy_.write("serve.state.day", before + before.substr(before.size() / 2, 100));
  const int port = free_port();
  Program again(arguments({"--port", std::to_string(port)}));
  again.write(header);
  for (int i = 0; i <= 3; ++i) again.write(warm_row(18300 + 60.0 * i));
  const nlohmann::json day = history_of(port, 62);
  ASSERT_GE(day["points"].size(), 62U);
  double last = -1;
  for (const nlohmann::json& point : day["points"]) {
    EXPECT_GT(double{point["t"]}, last);
    last = point["t"];
  }
  EXPECT_EQ(day["points"][0]["t"], 0.0);
  EXPECT_EQ(again.wait().status, 0);
  // Without the state, time begins anew, and the day with it.
  std::filesystem::remove(state());
  Program anew(arguments({"--port", std::to_string(port)}));
  anew.write(header);
  for (int i = 0; i <= 3; ++i) anew.write(warm_row(60.0 * i));
  EXPECT_LE(history_of(port, 3)["points"].size(), 4U);
  EXPECT_EQ(anew.wait().status, 0);
}

TEST_F(ServedPage, ShowsTheMachineInABrowser) {
  go_on_to(18060);
  moment_at(port_, 18061);
  if (browser().empty()) GTEST_SKIP() << "no chromium";
  // The browser looks on until the stream of events ends.
  auto looking = std::async(std::launch::async, followed, fmt::format("http://127.0.0.1:{}/", port_), file("browser"));
  for (int i = 0; i < 1000 && fetched(port_, "/now").find("Readers: 1") == std::string::npos; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  EXPECT_EQ(program_.wait().status, 0);
  const Page page = looking.get();
  expect_quiet(page);
  EXPECT_EQ(page.attribute("data-time"), "18061.5") << "the newest moment has come";
  EXPECT_EQ(page.attribute("data-old"), "false");
  EXPECT_NE(page.document.find("T4 kelvin"), std::string::npos);
  EXPECT_NE(page.document.find("follows the model"), std::string::npos);
  EXPECT_NE(page.document.find("served-x\">\xE2\x88\x92"), std::string::npos) << "an offset with its sign";
  EXPECT_GE(std::atoi(page.attribute_of("machine", "data-drawn").c_str()), 2) << "the field of the moment is drawn";
}

// The newest row may be hours old when somebody opens the page.
TEST_F(ServedPage, SaysHowOldItsValuesAre) {
  go_on_to(18060);
  moment_at(port_, 18061);
  program_.write("18062,nan,10,20.5,nan,nan,nan,nan\n");
  program_.read_line();
  const nlohmann::json day = json_of(fetched(port_, "/history"));
  ASSERT_EQ(day["sensors"].size(), 4U) << "as last known";
  EXPECT_EQ(day["sensors"][3]["id"], "T4");
  if (browser().empty()) GTEST_SKIP() << "no chromium";
  std::this_thread::sleep_for(std::chrono::milliseconds(10500));
  auto looking = std::async(std::launch::async, followed, fmt::format("http://127.0.0.1:{}/", port_), file("browser"));
  for (int i = 0; i < 1000 && fetched(port_, "/now").find("Readers: 1") == std::string::npos; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  EXPECT_EQ(program_.wait().status, 0);
  EXPECT_EQ(looking.get().attribute("data-old"), "true");
}

TEST_F(Serve, APortThatIsTakenIsRefusedAtTheStart) {
  const Tcp other;
  const int port = other.listen_anywhere();
  const Result result = thermotwin(arguments({"--port", std::to_string(port)}), header + row(0));
  EXPECT_EQ(result.status, 3);
  EXPECT_SAYS(result.err, fmt::format("--port {}", port));
  EXPECT_EQ(result.out, "");
}

}  // namespace
}  // namespace thermotwin::cases
