// Reads and prints samples like driver.c, but uses the class at the end of the header.
#include HEADER
#include <cmath>
#include <iostream>
#include <string>
#include <type_traits>

using Estimator = ESTIMATOR;
using Status = Estimator::status;

static_assert(std::is_nothrow_constructible<Estimator>::value, "it can be a member of a driver");

static Estimator estimator;
static Estimator by_ticks;
static Estimator by_step;

static bool is_number(const std::string &text, double &number)
{
    number = std::stod(text);
    return std::isfinite(number);
}

// Returns true if tared gauges have no load, for ticks and for steps.
static bool is_tared(const LOOPSCOPE_REAL *gauges)
{
    for (Estimator *other : {&by_ticks, &by_step})
        other->tare(gauges);
    if (by_ticks.update_ticks(7, gauges) != by_step.update_step(0, gauges))
        return false;
    by_ticks.update_ticks(50007, gauges);
    by_step.update_step(static_cast<LOOPSCOPE_REAL>(0.05), gauges);
    for (int axis = 0; axis < AXES; axis++) {
        const auto load = by_ticks.conventional()[axis], other = by_step.conventional()[axis];
        const auto least = static_cast<LOOPSCOPE_REAL>(1e-3);
        if (!(std::abs(load) < least && std::abs(other) < least))
            return false;
    }
    by_ticks.zero_last_load();
    by_step.reset();
    const Status first = by_step.update_ticks(1, gauges), next = by_ticks.update_ticks(50008, gauges);
    return !Estimator::is_rejected(first) && !Estimator::is_rejected(next);
}

int main()
{
    LOOPSCOPE_REAL gauges[GAUGES];
    std::string text;
    double time, number;
    bool is_good = true;
    std::cout.precision(17);
    if (!std::isnan(estimator.load()[0]))
        return 2; // before the first sample, the load must not be a number
    while (std::cin >> text) {
        is_good = is_number(text, time);
        for (auto &gauge : gauges) {
            std::cin >> text;
            is_good = is_number(text, number) && is_good;
            gauge = static_cast<LOOPSCOPE_REAL>(number);
        }
        const Status status = estimator.update(time, gauges);
        for (const auto load : estimator.load())
            std::cout << load << ' ';
        for (const auto load : estimator.conventional())
            std::cout << load << ' ';
        std::cout << static_cast<int>(status) << '\n';
        if (!is_good && (status != Status::rejected_value || !Estimator::is_rejected(status)))
            return 3;
    }
    return is_good && is_tared(gauges) ? 0 : 4;
}
