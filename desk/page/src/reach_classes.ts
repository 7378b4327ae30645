// What becomes of a facet (pathgen/reach/reach.h): words, colours, their order in the legend.
import {Color} from 'three';

export interface ReachClass { word: string; meaning: string; colour: string }

/** By the byte of GET reach/map. */
export const kClasses: ReachClass[] = [
  {word: 'cut', meaning: 'Cut', colour: '#3f9b5f'},
  {word: 'away', meaning: 'Faces away from the tool', colour: '#8d99a6'},
  {word: 'narrow', meaning: 'Too narrow for the cutter', colour: '#8e5fc2'},
  {word: 'blocked', meaning: 'Blocked by the part', colour: '#d2691e'},
  {word: 'tilt', meaning: 'Beyond the tilt', colour: '#2f6fd0'},
  {word: 'travel', meaning: 'Beyond the travels', colour: '#1aa5b8'},
  {word: 'outside', meaning: 'Outside the containment', colour: '#b8a64a'},
  {word: 'wall', meaning: 'Wall along the tool axis', colour: '#b04a6f'},
];

export const kClassColours = kClasses.map(({colour}) => new Color().setStyle(colour, ''));
