// OMPL's RRT-Connect with and without path simplification on tasks of rectangles, timed one after the other.
//
// Reads from stdin one task a line, `min_x min_y max_x max_y  start_x start_y goal_x goal_y  count (x0 y0 x1 y1)*count`;
// writes one line a task: solved, microseconds of solve, of simplification, length before and after it.
//
// The checks of points and motions are exact (a segment against the open rectangles), so OMPL pays for no sampling along
// motions. One setup serves all tasks, so its construction is not timed either; `clear` and new ends are.

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <iostream>
#include <memory>
#include <vector>

#include <ompl/base/MotionValidator.h>
#include <ompl/base/spaces/RealVectorStateSpace.h>
#include <ompl/geometric/SimpleSetup.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>
#include <ompl/util/Console.h>
#include <ompl/util/RandomNumbers.h>

namespace ob = ompl::base;
namespace og = ompl::geometric;
using Rect = std::array<double, 4>;

static std::vector<Rect> rects;

static const double *values(const ob::State *state) {
    return state->as<ob::RealVectorStateSpace::StateType>()->values;
}

/// Whether the segment meets the open rectangle.
static bool meets(const double *a, const double *b, const Rect &r) {
    double from = 0.0, to = 1.0;
    for (int axis = 0; axis < 2; ++axis) {
        const double d = b[axis] - a[axis], low = r[axis] - a[axis], high = r[axis + 2] - a[axis];
        if (d == 0.0) {
            if (low >= 0.0 || high <= 0.0) return false;
            continue;
        }
        from = std::max(from, std::min(low / d, high / d));
        to = std::min(to, std::max(low / d, high / d));
    }
    return from < to;
}

struct ExactMotion : ob::MotionValidator {
    using ob::MotionValidator::MotionValidator;
    bool checkMotion(const ob::State *a, const ob::State *b) const override {
        for (const Rect &r : rects)
            if (meets(values(a), values(b), r)) return false;
        return true;
    }
    bool checkMotion(const ob::State *a, const ob::State *b,
                     std::pair<ob::State *, double> &last) const override {
        last.second = 0.0;
        return checkMotion(a, b);
    }
};

static bool is_free(const ob::State *state) {
    const double *p = values(state);
    return std::none_of(rects.begin(), rects.end(), [p](const Rect &r) {
        return p[0] > r[0] && p[0] < r[2] && p[1] > r[1] && p[1] < r[3];
    });
}

int main() {
    ompl::msg::setLogLevel(ompl::msg::LOG_NONE);
    ompl::RNG::setSeed(1);
    auto space = std::make_shared<ob::RealVectorStateSpace>(2);
    og::SimpleSetup setup(space);
    setup.setStateValidityChecker(is_free);
    setup.getSpaceInformation()->setMotionValidator(
        std::make_shared<ExactMotion>(setup.getSpaceInformation()));
    auto planner = std::make_shared<og::RRTConnect>(setup.getSpaceInformation());
    setup.setPlanner(planner);
    ob::ScopedState<> start(space), goal(space);
    std::array<double, 4> bounds;
    bool is_ready = false;
    using clock = std::chrono::steady_clock;
    const auto us = [](clock::duration d) { return std::chrono::duration<double, std::micro>(d).count(); };
    while (std::cin >> bounds[0] >> bounds[1] >> bounds[2] >> bounds[3]) {
        std::size_t count = 0;
        std::cin >> start[0] >> start[1] >> goal[0] >> goal[1] >> count;
        rects.resize(count);
        for (Rect &r : rects) std::cin >> r[0] >> r[1] >> r[2] >> r[3];
        if (!is_ready) {
            ob::RealVectorBounds box(2);
            for (unsigned axis = 0; axis < 2; ++axis) {
                box.setLow(axis, bounds[axis]);
                box.setHigh(axis, bounds[axis + 2]);
            }
            space->setBounds(box);
        }
        const auto begin = clock::now();
        setup.clear();
        setup.setStartAndGoalStates(start, goal);
        if (!is_ready) setup.setup();
        is_ready = true;
        const bool solved = setup.solve(0.05) == ob::PlannerStatus::EXACT_SOLUTION;
        const auto found = clock::now();
        const double before = solved ? setup.getSolutionPath().length() : 0.0;
        const auto again = clock::now();
        if (solved) setup.simplifySolution();
        const auto done = clock::now();
        const double after = solved ? setup.getSolutionPath().length() : 0.0;
        std::printf("%d %.3f %.3f %.9g %.9g\n", solved, us(found - begin), us(done - again), before, after);
    }
}
