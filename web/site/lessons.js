"use strict";
// Five lessons: a text, a task, and what is asked.
const BESIDE = { format: "sidestep.task/1", name: "a block beside the way", bounds: [[0, 0], [64, 64]], obstacles: [{ rect: [[26, 14], [38, 36]] }], robot: "point", start: [6, 32], goal: [58, 32] };
const WALL = { format: "sidestep.task/1", name: "a wall across the way", bounds: [[0, 0], [64, 64]], obstacles: [{ rect: [[28, 10], [36, 50]] }, { rect: [[14, 42], [28, 50]] }], robot: "point", start: [6, 30], goal: [58, 30] };
const HARD = {
  format: "sidestep.task/1", name: "hard, seed 1, candidate 25", bounds: [[0, 0], [64, 64]],
  obstacles: [
    { rect: [[39, 31], [52, 46]] }, { rect: [[46, 63], [65, 81]] }, { rect: [[0, 45], [19, 57]] }, { rect: [[46, 30], [59, 47]] }, { rect: [[51, 4], [64, 21]] },
    { rect: [[1, 14], [13, 33]] }, { rect: [[5, 39], [23, 57]] }, { rect: [[15, 36], [31, 48]] }, { rect: [[51, 38], [65, 56]] }, { rect: [[35, 6], [50, 22]] },
  ],
  robot: "point", start: [26, 9], goal: [4, 61],
};
const LESSONS = [
  {
    title: "What U is", task: BESIDE, planners: ["gd"],
    text: `A plan is a row of waypoints from start to goal. U = F_obs + λ F_len says how bad it is: F_obs grows where waypoints come near an obstacle (the blue shade is what a place costs) or are in it, F_len with the length.
Gradient descent asks which way each waypoint must move so that U falls, and moves it a little: 'steps' shows these moves as arrows. Drag the slider and watch U fall in the first chart, until the plan is certified free of collision.
Try: move the block up or down, or give the robot a radius.`,
  },
  {
    title: "Why descent gets stuck", task: WALL, planners: ["gd", "momentum", "adam"],
    text: `The wall pushes each waypoint to its nearest side. The waypoints that are pushed forward and those that are pushed back pull at the same string of waypoints, and neither side gives way: U cannot fall any more, and the plan still goes through the wall. That is a local optimum. Momentum and Adam roll on for a while, and get stuck as well.
Under each panel stands where the plan is blocked; the cross marks the place.
Try: make the wall shorter, until descent finds its way round.`,
  },
  {
    title: "Step size", task: BESIDE, planners: ["gd:step=0.01", "gd:step=0.5", "gd", "gd:step=50"],
    text: `The same task, the same gradient, four sizes of step: 0.01, 0.5, 2 and 50. The first hardly moves within 40 steps, the second is on its way and not there yet, the third is through, and the last throws the waypoints about and never settles.
Try: give it more steps, and see which of them get through.`,
  },
  {
    title: "Many starts", task: WALL, planners: ["gd", "adam"], set: { starts: 5 },
    text: `Descent finds the bottom of the valley that it begins in. So begin in several: the first start is the straight line, the others lead over a place drawn at random. Of five starts one is enough that lies on the right side of the wall.
Try: one start, then two; another seed draws other starts. On the task of the last lesson it takes more luck.`,
  },
  {
    title: "An optimizer that learned", task: HARD, planners: ["gd", "momentum", "adam", "sidestep-1"],
    text: `sidestep-1 sees what the others see: where the waypoints are, how far from obstacles, which way the gradient points. It has learned from many other tasks what to answer, and where descent would settle against a wall it leads the waypoints round. From one straight line it solves 98 of 100 tasks that are hard for descent.
Turn 'steps' on to see its answer at each waypoint. Then train one of your own, below at the right: the paper's policy, in this page.`,
  },
];
