import { previewOf, useStore } from './store';
import { DistributionView } from './distribution';
import { ImageView } from './images';
import { LabelsView } from './labels';
import { useNearest, useNode } from './load';
import { MatrixView } from './matrix';
import { ProfilesView } from './profiles';
import { noWebGL, ParticlesView, ShapesView, webGL } from './solids';
import { Summary } from './summary';
import { TableView } from './tables';
import { VolumeView } from './volumes';
import type { DocNode, OutputValue } from './types';

// A value that cannot be drawn here: a picture that the graph has made of it, and a summary.
function OtherView({ value, node }: { value: OutputValue; node: DocNode }) {
  const solid = ['Volume', 'Shapes', 'Particles'].includes(value.type), picture = useNearest(node.name, 'Image', 'down');
  const nodes = useStore(s => s.nodes), from = useNode(picture?.target.node);
  return (
    <div className="both">
      {solid && picture && <figure><ImageView value={(from && previewOf(from, picture.target.port, nodes)) ?? picture.value} node={node} /><figcaption>{noWebGL} This is {picture.target.node}.{picture.target.port}, made from this value.</figcaption></figure>}
      {solid && !picture && <p className="none">{noWebGL} Nothing in the graph makes a picture of this value; RenderSolid does.</p>}
      <Summary value={value} />
    </div>
  );
}

export function View({ value, node }: { value: OutputValue; node: DocNode }) {
  switch (value.type) {
    case 'Image': return <ImageView value={value} node={node} />;
    case 'Labels': return <LabelsView value={value} node={node} />;
    case 'Profiles': return <ProfilesView value={value} node={node.name} />;
    case 'Table': return <TableView value={value} />;
    case 'SizeDistribution': return <DistributionView value={value} node={node} />;
    case 'KMatrix': return <MatrixView value={value} />;
    case 'Volume': return <VolumeView value={value} node={node} />;
    case 'Particles': if (webGL) return <ParticlesView value={value} node={node} />; break;
    case 'Shapes': if (webGL) return <ShapesView value={value} node={node} />; break;
  }
  return <OtherView value={value} node={node} />;
}
