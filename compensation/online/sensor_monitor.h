// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Temperature sensors that have failed are found, named and left out of the observer. A reading is
// compared with what the observer expects of it; the slow part of that difference is model error and
// is followed, a leap from one reading to the next is the sensor's:
// - absent: no reading for five minutes, after there was one;
// - stuck: the very same reading (to a tenth of its deviation) while the expected one has moved by 5 sigma, or
//   for five minutes and more often in a row than its own scatter so far lets happen by chance (1e-12);
// - offset: the difference leaps by more than 12 sigma and stays there (or stands out from the start
//   by 1 K and by far among the sensors);
// - noise: second differences beyond 3.5 of their deviations in quick succession.
// Readings after a leap are withheld at once, before the fault has its name, so that they do no
// harm. sigma is the sensor's stated deviation, at least 0.03 K, plus a tenth of what the expected
// reading moved, since a model errs most while things change; where an input has leapt since the row
// before, leaps and noise have to exceed all that it moved, since nobody knows at what time between the two. A sensor
// comes back once its readings have agreed for half an hour without a break, and to less than half of a leap: while
// much changes, that alone would agree with anything. Limits: a sensor that drifts slowly is taken for model error, and
// one that is off from the start by less than its neighbours differ is not found.

#include <Eigen/Core>

#include <deque>
#include <string>
#include <vector>

namespace thermotwin::compensation {

enum class SensorFault { none, absent, stuck, offset, noise };
const char* fault_text(SensorFault fault);

class SensorMonitor {
public:
  /// @param deviation_K  (sensors) stated standard deviation of a reading
  explicit SensorMonitor(const Eigen::VectorXd& deviation_K);

  /// Judges the readings of one time. @param reading_K  (sensors) NaN where missing
  /// @param expected_K  (sensors) by the observer  @param inputs_leapt  since the last call: a speed, a state
  /// @param unsure_K_s  (sensors) standard deviation of how fast the expected readings change; empty: they are sure
  /// @return whether anything changed its name
  bool judge(double time, const Eigen::VectorXd& reading_K, const Eigen::VectorXd& expected_K,
             bool inputs_leapt = false, const Eigen::VectorXd& unsure_K_s = {});
  /// Before the first readings: sensors whose first one the others explain, however far it is from what is expected.
  void explain_first(std::vector<char> explained) { explained_ = std::move(explained); }
  /// The observer has learnt: what it expects moves by as much, and the sensors have nothing to do with that.
  void correct(const Eigen::VectorXd& change_K);

  /// Whether the last reading may correct the model.
  bool trusted(Eigen::Index sensor) const { return sensors_[sensor].trusted; }
  SensorFault fault(Eigen::Index sensor) const { return sensors_[sensor].fault; }
  bool any_fault() const { return faults_ > 0; }

private:
  struct Sample {
    double time, difference;
    bool far;
  };
  /// What one row says of a sensor besides its reading.
  struct Row {
    double time, expected;
    double others;  ///< what sensors differ by from what is expected
    double unsure_K_s;
    bool inputs_leapt, explained;
  };
  struct Judged {
    const Row& row;
    double deviation, reading;
    double interval;    ///< s, since the reading before
    double difference;  ///< from what is expected and usual
    double step;        ///< of what is expected, since the reading before
    double unsure, unknown;
  };
  struct Sensor {
    SensorFault fault = SensorFault::none;
    bool trusted = true, known = false, leapt = false,
         from_start = false;  ///< from_start: far off at its first reading
    double seen_at = 0, last_reading = 0;
    double usual = 0;  ///< slow part of reading - expected; stands after a leap
    double last_difference = 0, last_expected = 0, last_unknown = 0;
    double expected_memory = 0;                                 ///< slow part of the expected reading
    double same_value = 0, same_expected = 0, same_unsure = 0;  ///< same_unsure: K, of what it moved since
    int same_count = 0;
    double same_since = 0;
    double readings = 0, repeats = 0;  ///< in runs that have ended: how often readings repeat by chance
    double smallest_step = 0;          ///< of the reading's digits, where it has coarse ones
    double leapt_at = -1, leap = 0, agreed_since = -1;  ///< s; K; s
    std::deque<Sample> recent;

    void judge(double deviation, double reading, const Row& row);

  private:
    void start(double time, double reading, double expected);
    void arrive(double deviation, double reading, const Row& row);
    bool stands_apart(const Judged& now);
    bool is_stuck(const Judged& now);
    bool is_noisy(const Judged& now);
    void name_fault(double time, bool apart, bool stuck, bool noisy);
  };

  Eigen::VectorXd deviation_;
  std::vector<char> explained_;
  std::vector<Sensor> sensors_;
  int faults_ = 0;
};

}  // namespace thermotwin::compensation
